#pragma once
#include <vector>

#include "common/base/limits.hpp"
#include "worker/render/scene.hpp"
#include "worker/scene/merge.hpp"

namespace tessera::worker {

/// Adds the lights that a group's emitting faces are where `to_world` puts them, in order, and says
/// which is the first; no_id, and none is added, where there would be more than `most`. Throws
/// Error{bad_input} for a sphere that becomes an ellipsoid.
std::uint32_t add_lights(const MergedGroup& group,
                         std::span<const render::CompiledMaterial> materials,
                         const scene::Transform& to_world, std::uint32_t instance,
                         std::vector<render::Light>& lights,
                         std::size_t most = limits::light_faces);

/// A light that is no surface, in a scene that was moved by −`origin` and lies within `bounds`.
render::Light punctual_light(const scene::PunctualLight& light, const std::array<double, 3>& origin,
                             const render::Bounds3& bounds);

/// A bound of the rounding error of a light's points, for itself and for rays that meet it: those
/// are brought into the space of its group, where it may stand far off. The scene has its groups
/// and placements.
float rounding_error(const render::Light& light, const render::Scene& scene);

}  // namespace tessera::worker
