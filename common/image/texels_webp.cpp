#include <webp/decode.h>

#include "common/image/texels_decode.hpp"

namespace tessera::image {

Texels decode_webp(std::span<const std::byte> file, const PictureSource& source) {
  const std::string& name = source.name;
  const auto* const bytes = reinterpret_cast<const std::uint8_t*>(file.data());
  WebPBitstreamFeatures features{};
  if (WebPGetFeatures(bytes, file.size(), &features) != VP8_STATUS_OK)
    refuse_picture(name, "not a valid WebP file: its header cannot be read");
  if (features.has_animation != 0) refuse_picture(name, "an animated WebP; expected one picture");
  const bool alpha = features.has_alpha != 0;
  Texels out = picture_of(features.width, features.height, alpha ? 4 : 3, TexelFormat::u8, source);
  auto* const to = reinterpret_cast<std::uint8_t*>(out.bytes.data());
  const auto stride = static_cast<int>(out.row_bytes());
  const std::uint8_t* const done =
      alpha ? WebPDecodeRGBAInto(bytes, file.size(), to, out.bytes.size(), stride)
            : WebPDecodeRGBInto(bytes, file.size(), to, out.bytes.size(), stride);
  if (done == nullptr) refuse_picture(name, "not a valid WebP file: broken or cut short");
  return out;
}

}  // namespace tessera::image
