#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "common/scene/description.hpp"

/// What ids and mattes tell apart: things of one name are one.
namespace tessera::scene {

struct ObjectNames {
  std::vector<std::string> names;          ///< each once, in the order in which the scene has them
  std::vector<std::uint32_t> of_shape;     ///< by Scene::shapes: which of them, and …
  std::vector<std::uint32_t> of_instance;  ///< … by Scene::instances
};
/// Each shape of the world is an object, and each instance, under its own name or its object's.
ObjectNames object_names(const Scene& scene);

struct MaterialNames {
  std::vector<std::string> names;
  std::vector<std::uint32_t> of_material;  ///< by Scene::materials
};
MaterialNames material_names(const Scene& scene);

}  // namespace tessera::scene
