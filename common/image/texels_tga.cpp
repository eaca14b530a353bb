#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <climits>
#include <cstring>
#include <memory>

#include "common/base/limits.hpp"
#include "common/image/texels_decode.hpp"

#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_TGA
#define STBI_NO_STDIO
#define STBI_MAX_DIMENSIONS 65536
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image.h>
#pragma GCC diagnostic pop

namespace tessera::image {

namespace {

/// The fields of its 18 bytes, little-endian.
struct Header {
  std::size_t id_bytes = 0, palette_entries = 0, palette_bits = 0;
  int palette = 0, type = 0, width = 0, height = 0, bits = 0;

  explicit Header(std::span<const std::byte> file) {
    const auto at = [&](std::size_t i) { return std::to_integer<int>(file[i]); };
    id_bytes = static_cast<std::size_t>(at(0));
    palette = at(1);
    type = at(2);
    palette_entries = static_cast<std::size_t>(at(5)) + 256 * static_cast<std::size_t>(at(6));
    palette_bits = static_cast<std::size_t>(at(7));
    width = at(12) + 256 * at(13);
    height = at(14) + 256 * at(15);
    bits = at(16);
  }
  [[nodiscard]] bool packed() const { return type >= 9; }
  [[nodiscard]] std::size_t texel_bytes() const { return (static_cast<std::size_t>(bits) + 7) / 8; }
  [[nodiscard]] std::size_t first_texel() const {
    return header_bytes + id_bytes +
           (palette == 1 ? palette_entries * ((palette_bits + 7) / 8) : 0);
  }
  static constexpr std::size_t header_bytes = 18;
};

/// The decoder takes what lies beyond the file's end for zeros, so it is looked for here.
bool ends_too_early(std::span<const std::byte> file, const Header& header) {
  const std::size_t texels =
      static_cast<std::size_t>(header.width) * static_cast<std::size_t>(header.height);
  const std::size_t size = header.texel_bytes();
  std::size_t at = header.first_texel();
  if (at > file.size()) return true;
  if (!header.packed()) return (file.size() - at) / size < texels;
  for (std::size_t done = 0; done < texels;) {
    if (at >= file.size()) return true;
    const auto packet = std::to_integer<std::size_t>(file[at]);
    const std::size_t count = 1 + (packet & 127U);
    at += 1 + ((packet & 128U) != 0 ? 1 : count) * size;
    if (at > file.size()) return true;
    done += count;
  }
  return false;
}

}  // namespace

bool looks_like_tga(std::span<const std::byte> file) {
  if (file.size() < Header::header_bytes) return false;
  const Header header(file);
  const int kind = header.type & ~8;
  const bool depth = header.bits == 8 || header.bits == 15 || header.bits == 16 ||
                     header.bits == 24 || header.bits == 32;
  return header.palette <= 1 && header.type <= 11 && kind >= 1 && kind <= 3 && depth &&
         (header.palette == 1) == (kind == 1) && header.width > 0 && header.height > 0;
}

Texels decode_tga(std::span<const std::byte> file, const PictureSource& source) {
  const std::string& name = source.name;
  if (!looks_like_tga(file)) refuse_picture(name, "not a valid TGA file: its header is none");
  const Header header(file);
  if (file.size() > static_cast<std::size_t>(INT_MAX)) refuse_picture(name, "too large a TGA file");
  const auto* const bytes = reinterpret_cast<const stbi_uc*>(file.data());
  const auto size = static_cast<int>(file.size());
  int width = 0, height = 0, channels = 0;
  const auto refuse = [&](std::string_view why) {
    refuse_picture(name, fmt::format("not a valid TGA file: {}", why));
  };
  if (stbi_info_from_memory(bytes, size, &width, &height, &channels) == 0) {
    refuse(stbi_failure_reason());
  }
  if (ends_too_early(file, header)) refuse("the file ends too early");
  Texels out = picture_of(width, height, channels, TexelFormat::u8, source);
  const std::unique_ptr<stbi_uc, void (*)(void*)> texels(
      stbi_load_from_memory(bytes, size, &width, &height, &channels, 0), stbi_image_free);
  if (texels == nullptr) refuse(stbi_failure_reason());
  if (width != out.width || height != out.height || channels != out.channels) refuse("odd header");
  std::memcpy(out.bytes.data(), texels.get(), out.bytes.size());
  return out;
}

}  // namespace tessera::image
