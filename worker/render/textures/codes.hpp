#pragma once
#include "common/image/texels.hpp"
#include "common/scene/texture.hpp"

namespace tessera::render {

/// What each code of an integer format is, linear: 256 or 65536 floats, made once. `space` srgb:
/// the curve of IEC 61966-2-1.
const float* decoding_table(image::TexelFormat format, scene::ColorSpace space);

/// The code whose meaning in that table is nearest to `linear`.
std::uint16_t nearest_code(const float* table, image::TexelFormat format, float linear);

}  // namespace tessera::render
