#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "common/image/texels.hpp"

/// Each format's decoder, and what they share. texels.hpp is the door.
namespace tessera::image {

/// Throws Error{bad_input} at `name`.
[[noreturn]] void refuse_picture(const std::string& name, std::string_view message);

/// Room for a picture whose header says this; throws Error{too_large} at `name` before anything is
/// allocated if it is beyond limits.hpp, Error{bad_input} if it has no texels, or if the file is
/// shorter than `least_bytes`, the fewest that its format can put such a picture into.
Texels picture_of(std::int64_t width, std::int64_t height, int channels, TexelFormat format,
                  const std::string& name, std::uint64_t least_bytes = 0,
                  std::uint64_t file_bytes = 0);

// All throw Error{bad_input, too_large} at `name` for what is broken, cut short or beyond limits.
Texels decode_png(std::span<const std::byte> file, const std::string& name);
Texels decode_jpeg(std::span<const std::byte> file, const std::string& name);
Texels decode_webp(std::span<const std::byte> file, const std::string& name);
Texels decode_tga(std::span<const std::byte> file, const std::string& name);
Texels decode_hdr(std::span<const std::byte> file, const std::string& name);
Texels decode_exr(std::span<const std::byte> file, const std::string& name);

/// TGA has no mark of its own: true if the first bytes make sense as its header.
bool looks_like_tga(std::span<const std::byte> file);

/// NaN becomes 0, what is infinite or beyond `most` ±most: a sum of texels stays a number.
float tamed(float value, float most);
constexpr float half_most = 65504;
constexpr float float_most = 1e30F;

}  // namespace tessera::image
