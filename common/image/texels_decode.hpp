#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "common/image/texels.hpp"

/// Each format's decoder, and what they share. texels.hpp is the door.
namespace tessera::image {

/// What a decoder is told of a picture beside its bytes.
struct PictureSource {
  std::string name;               ///< in errors
  TexelBudget* budget = nullptr;  ///< what its texels are taken from
};

/// Throws Error{bad_input} at `name`.
[[noreturn]] void refuse_picture(const std::string& name, std::string_view message);

/// Room for a picture whose header says this; throws Error{too_large} at its name before anything
/// is allocated if it is beyond limits.hpp or its budget, Error{bad_input} if it has no texels, or
/// if the file is shorter than `least_bytes`, the fewest that its format can put such a picture
/// into.
Texels picture_of(std::int64_t width, std::int64_t height, int channels, TexelFormat format,
                  const PictureSource& source, std::uint64_t least_bytes = 0,
                  std::uint64_t file_bytes = 0);

// All throw Error{bad_input, too_large} at the name for what is broken, cut short or beyond limits.
Texels decode_png(std::span<const std::byte> file, const PictureSource& source);
Texels decode_jpeg(std::span<const std::byte> file, const PictureSource& source);
Texels decode_webp(std::span<const std::byte> file, const PictureSource& source);
Texels decode_tga(std::span<const std::byte> file, const PictureSource& source);
Texels decode_hdr(std::span<const std::byte> file, const PictureSource& source);
Texels decode_exr(std::span<const std::byte> file, const PictureSource& source);

/// TGA has no mark of its own: true if the first bytes make sense as its header.
bool looks_like_tga(std::span<const std::byte> file);

/// NaN becomes 0, what is infinite or beyond `most` ±most: a sum of texels stays a number.
float tamed(float value, float most);
constexpr float half_most = 65504;
constexpr float float_most = 1e30F;

}  // namespace tessera::image
