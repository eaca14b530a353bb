#pragma once
#include <memory>

#include "common/scene/description.hpp"
#include "worker/render/lights/environment_map.hpp"
#include "worker/render/textures/texture_table.hpp"

namespace tessera::worker {

/// Reads and decodes the pictures that textures use, each once, and makes their levels, with the
/// threads of the calling TBB arena. Throws Error at the first picture, in their order, that cannot
/// be had: not_found, bad_input for one that is broken, too_large for one beyond limits.hpp or if
/// all together take more than half of this machine's memory.
render::TextureTable load_textures(const scene::Scene& from);

/// The environment's picture, which there is. Throws Error as above.
std::shared_ptr<const render::EnvironmentMap> load_environment(const scene::Scene& from);

}  // namespace tessera::worker
