#pragma once
#include <cmath>
#include <cstring>
#include <string>

#include "common/base/limits.hpp"
#include "common/image/texels.hpp"
#include "common/image/texels_decode.hpp"
#include "tests/fuzz/target.hpp"

namespace tessera::fuzz {

/// A decoded picture keeps the promises of texels.hpp.
inline void check(const image::Texels& picture) {
  require(picture.width > 0 && picture.height > 0, "a picture has texels");
  require(picture.channels >= 1 && picture.channels <= 4, "a picture has one to four channels");
  require(picture.bytes.size() == picture.row_bytes() * static_cast<std::size_t>(picture.height),
          "a picture has all its bytes");
  require(picture.bytes.size() <= limits::image_bytes, "a picture is within the limit");
  if (picture.format != image::TexelFormat::f32) return;
  for (std::size_t at = 0; at < picture.bytes.size(); at += sizeof(float)) {
    float value = 0;
    std::memcpy(&value, picture.bytes.data() + at, sizeof value);
    require(std::isfinite(value), "floats of a picture are finite");
  }
}

template <class Decoder>
void decode(const Decoder& decoder, const std::uint8_t* data, std::size_t size) {
  take_or_refuse([&] { check(decoder(bytes_of(data, size), {"picture"})); });
}

}  // namespace tessera::fuzz
