#pragma once
#include <span>
#include <vector>

#include "worker/render/scene.hpp"

namespace tessera::worker {

/// The mean radiance of each of a geometry's faces, as its material and the part of its picture
/// that it covers have it; black where none of that emits. A face costs at most some hundred
/// look-ups, however much of a picture it covers. Works with the threads of the calling TBB arena.
std::vector<render::Color> mean_radiances(const render::Geometry& geometry,
                                          std::span<const render::CompiledMaterial> materials,
                                          const render::TextureTable& textures);

}  // namespace tessera::worker
