#pragma once
#include <cstdint>
#include <string_view>
#include <vector>

#include "common/scene/description.hpp"

/// What ids and mattes tell apart: things of one name are one.
namespace tessera::scene {

/// Its own, or its object's.
std::string_view name_of(const Scene& scene, const Instance& instance);

struct ObjectNames {
  /// Each once, in the order in which the scene has them; the scene's, as long as it stays as it
  /// is.
  std::vector<std::string_view> names;
  std::vector<std::uint32_t> of_shape;     ///< by Scene::shapes: which of them, and …
  std::vector<std::uint32_t> of_instance;  ///< … by Scene::instances
};
/// Each shape of the world is an object, and each instance, under its own name or its object's.
ObjectNames object_names(const Scene& scene);
ObjectNames object_names(Scene&& scene) = delete;

struct MaterialNames {
  std::vector<std::string_view> names;     ///< as ObjectNames has them
  std::vector<std::uint32_t> of_material;  ///< by Scene::materials
};
MaterialNames material_names(const Scene& scene);
MaterialNames material_names(Scene&& scene) = delete;

}  // namespace tessera::scene
