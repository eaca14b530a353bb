#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/scene/texture.hpp"

namespace tessera::scene {

/// How many bytes the picture has before it is decoded. Throws Error at the image's name:
/// not_found, bad_input if its range leaves its file.
std::uint64_t encoded_size(const Image& image);

/// Those bytes: read, or the ones in memory. Throws Error at the image's name as encoded_size()
/// does, too_large beyond limits::image_file_bytes before memory is taken, failed if they cannot
/// be read.
std::shared_ptr<const std::vector<std::byte>> encoded_bytes(const Image& image);

}  // namespace tessera::scene
