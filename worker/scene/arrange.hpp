#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/scene/description.hpp"
#include "common/scene/object_names.hpp"
#include "worker/render/bsdf/material.hpp"
#include "worker/render/scene.hpp"

namespace tessera::worker {

/// A shape and where it stands in its group.
struct PlacedShape {
  scene::Shape* shape = nullptr;
  scene::Transform to_group;
  scene::Visibility visibility = {};     ///< within its group
  std::uint32_t object = render::no_id;  ///< which of ObjectNames; no_id: as its group is placed
};

/// Which shapes are merged into which group, and where groups are placed. Group 0 is the world's
/// own and has no entry in `placed`; transforms of its shapes lead to the world.
struct Arrangement {
  struct Placed {
    std::size_t group = 0;
    scene::Transform to_world;
    scene::Visibility visibility = {};
    std::uint32_t object = 0;  ///< which of ObjectNames
  };
  std::vector<std::vector<PlacedShape>> groups;
  std::vector<Placed> placed;
};

/// Shapes of the world and objects placed once go into the world. An object placed more often
/// becomes a group. A sphere whose transform makes it an ellipsoid becomes a group of its own, as
/// only an instance can bend it; so does one that is turned and whose material wants details, as
/// the sphere that renders has no orientation. Objects that nothing places are left out.
/// `objects` are the description's.
Arrangement arrange(scene::Scene& description, std::span<const render::CompiledMaterial> materials,
                    const scene::ObjectNames& objects);

/// Corners of an axis-aligned box in double.
struct Extent {
  std::array<double, 3> low, high;
  [[nodiscard]] bool empty() const { return !(low[0] <= high[0]); }
};
/// Of each group, in its own space.
std::vector<Extent> extents_of_groups(const Arrangement& arrangement);
/// Of all that is placed, in the world; `of_group` is what extents_of_groups() says.
Extent extent_of(const Arrangement& arrangement, std::span<const Extent> of_group);

}  // namespace tessera::worker
