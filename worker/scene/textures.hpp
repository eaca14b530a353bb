#pragma once
#include <cstdint>
#include <memory>

#include "common/image/texels.hpp"
#include "common/scene/description.hpp"
#include "worker/render/lights/environment_map.hpp"
#include "worker/render/textures/texture_table.hpp"

namespace tessera::worker {

/// What the decoded pictures of one scene may take of this machine, bytes: half of its memory, as
/// mip levels are a third more and there is more to a scene, and no more than limits.hpp has.
std::uint64_t picture_bytes_most();

/// Reads and decodes the pictures that textures use, each once, and makes their levels, with the
/// threads of the calling TBB arena. Throws Error at the first picture, in their order, that cannot
/// be had: not_found, bad_input for one that is broken, too_large for one beyond limits.hpp or for
/// which `budget` has too little left.
render::TextureTable load_textures(const scene::Scene& from, image::TexelBudget& budget);

/// The environment's picture, which there is. Throws Error as above.
std::shared_ptr<const render::EnvironmentMap> load_environment(const scene::Scene& from,
                                                               image::TexelBudget& budget);

}  // namespace tessera::worker
