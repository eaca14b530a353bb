#pragma once
#include <memory>
#include <string>

#include "worker/agent/renderer.hpp"

namespace tessera::agent {

/// The path tracer of worker/render over Embree, with `threads` threads for all that it does.
/// Throws Error{failed} if this machine lacks what it needs.
std::unique_ptr<TaskRenderer> make_path_renderer(int threads);

}  // namespace tessera::agent
