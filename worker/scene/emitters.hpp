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

/// A bound of the rounding error of a light's points.
float rounding_error(const render::Light& light);

}  // namespace tessera::worker
