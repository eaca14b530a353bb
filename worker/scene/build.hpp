#pragma once
#include "common/scene/description.hpp"
#include "worker/accel/accel.hpp"
#include "worker/render/scene.hpp"

namespace tessera::worker {

/// From a description to what renders. Shapes that are placed once are baked into the world, in
/// double, and merged by kind; objects that are placed more often become instances, of one level.
/// Every face of an emitting material becomes a light, or two triangles together that are a
/// parallelogram, as far as limits::light_faces reach. The description is used up: a mesh is freed
/// as soon as it is copied, so that no two copies of all meshes are ever held. What AOVs alone look
/// at is kept as `needs` says. The hierarchies are built with the threads of the calling TBB arena.
/// Throws Error{bad_input} for what cannot be rendered (an emitting sphere under a transform that
/// makes it no sphere; an instance under a transform that has no inverse), Error{too_large} for
/// more than 65536 materials, Error{failed} for what Embree says.
render::Scene build_scene(scene::Scene&& description, const accel::Device& device,
                          const accel::Progress& progress = {},
                          const render::SceneNeeds& needs = {});

}  // namespace tessera::worker
