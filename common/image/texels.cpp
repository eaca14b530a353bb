#include "common/image/texels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "common/image/texels_decode.hpp"

namespace tessera::image {

namespace {

struct Format {
  std::size_t at;  ///< where its mark stands
  std::string_view mark;
  Texels (*decode)(std::span<const std::byte>, const PictureSource&);
};
using namespace std::string_view_literals;
constexpr std::array<Format, 6> formats{{{0, "\x89PNG\r\n\x1a\n"sv, decode_png},
                                         {0, "\xff\xd8\xff"sv, decode_jpeg},
                                         {8, "WEBP"sv, decode_webp},
                                         {0, "\x76\x2f\x31\x01"sv, decode_exr},
                                         {0, "#?RADIANCE"sv, decode_hdr},
                                         {0, "#?RGBE"sv, decode_hdr}}};

bool has_mark(std::span<const std::byte> file, const Format& format) {
  return file.size() >= format.at + format.mark.size() &&
         std::memcmp(file.data() + format.at, format.mark.data(), format.mark.size()) == 0;
}

}  // namespace

void refuse_picture(const std::string& name, std::string_view message) {
  throw Error(ErrorKind::bad_input, std::string(message), {.file = name, .key = {}});
}

Texels picture_of(std::int64_t width, std::int64_t height, int channels, TexelFormat format,
                  const PictureSource& source, std::uint64_t least_bytes,
                  std::uint64_t file_bytes) {
  const std::string& name = source.name;
  if (width < 1 || height < 1)
    refuse_picture(name, fmt::format("a picture of {} by {} has no texels", width, height));
  const auto texel = static_cast<std::int64_t>(bytes_of(format)) * channels;
  constexpr auto most = static_cast<std::int64_t>(limits::image_bytes);
  if (width > limits::image_side || height > limits::image_side || width * height > most / texel)
    throw Error(
        ErrorKind::too_large,
        fmt::format("a picture of {} by {} texels of {} bytes; its sides may have {}, and "
                    "all of it {} MiB",
                    width, height, texel, limits::image_side, limits::image_bytes / limits::MiB),
        {.file = name, .key = {}});
  if (file_bytes < least_bytes)
    refuse_picture(name, fmt::format("a picture of {} by {} texels needs {} bytes or more, and the "
                                     "file has {}: it ends too early",
                                     width, height, least_bytes, file_bytes));
  const auto bytes = static_cast<std::uint64_t>(width * height * texel);
  if (source.budget != nullptr) source.budget->take(bytes, name);
  Texels out;
  out.width = static_cast<int>(width);
  out.height = static_cast<int>(height);
  out.channels = channels;
  out.format = format;
  out.bytes.resize(bytes);
  return out;
}

float tamed(float value, float most) {
  return std::isnan(value) ? 0.0F : std::clamp(value, -most, most);
}

void TexelBudget::take(std::uint64_t bytes, const std::string& name) {
  std::uint64_t left = left_;
  do {
    if (bytes > left)
      throw Error(
          ErrorKind::too_large,
          fmt::format("with its {} MiB, the scene's pictures take more than {} MiB together",
                      bytes / limits::MiB, most_ / limits::MiB),
          {.file = name, .key = {}});
  } while (!left_.compare_exchange_weak(left, left - bytes));
}

Texels decode_texels(std::span<const std::byte> file, const std::string& name,
                     TexelBudget* budget) {
  const PictureSource source{.name = name, .budget = budget};
  for (const Format& format : formats)
    if (has_mark(file, format)) return format.decode(file, source);
  if (looks_like_tga(file)) return decode_tga(file, source);
  refuse_picture(name, file.empty() ? "an empty file, no picture"
                                    : "not a picture of a known format (PNG, JPEG, WebP, TGA, HDR "
                                      "or EXR)");
}

}  // namespace tessera::image
