#pragma once
#include <vector>

#include "worker/render/scene.hpp"
#include "worker/scene/merge.hpp"

namespace tessera::worker {

/// The lights that a group's emitting faces are where `placement` puts them, in order. Throws
/// Error{bad_input} for a sphere that becomes an ellipsoid.
std::vector<render::Light> lights_of(const MergedGroup& group,
                                     std::span<const render::CompiledMaterial> materials,
                                     const scene::Transform& to_world, std::uint32_t instance);

/// A light without a size, in a scene that was moved by −`origin` and lies within `bounds`.
render::Light punctual_light(const scene::PunctualLight& light, const std::array<double, 3>& origin,
                             const render::Bounds3& bounds);

/// A bound of the rounding error of a light's points.
float rounding_error(const render::Light& light);

}  // namespace tessera::worker
