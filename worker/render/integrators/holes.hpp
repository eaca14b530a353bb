#pragma once
#include "worker/render/integrators/path_steps.hpp"

/// Where the camera sees a hole in place of a surface.
namespace tessera::render {

/// Asks what a hole is. Of a shadow catcher it notes the light that falls on it, if the record has
/// extras.
bool look_into_hole(Trace& trace, const Sampler& sampler, const PathState& path,
                    const Interaction& at, Closure& closure, SampleRecord& record);

/// True if the camera sees a hole where the path is: the path ends, and what is told of it is told.
/// Leaves the closure as it likes if so.
inline bool is_hole(Trace& trace, const Sampler& sampler, const PathState& path,
                    const Interaction& at, Closure& closure, SampleRecord& record) {
  return trace.scene.has_holes && path.depth == 0 &&
         look_into_hole(trace, sampler, path, at, closure, record);
}

}  // namespace tessera::render
