#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

/// Decoded pictures as they came: in their own depth, with the channels that they have.
namespace tessera::image {

enum class TexelFormat : std::uint8_t {
  u8,   ///< 0…255 stands for 0…1
  u16,  ///< 0…65535 stands for 0…1
  f16,  ///< half floats
  f32
};
constexpr std::size_t bytes_of(TexelFormat format) {
  constexpr std::size_t bytes[] = {1, 2, 2, 4};
  return bytes[static_cast<std::size_t>(format)];
}
constexpr bool is_integer(TexelFormat format) {
  return format == TexelFormat::u8 || format == TexelFormat::u16;
}

/// Rows from the upper one, without gaps, channels interleaved, in this machine's byte order. One
/// channel is a gray, two a gray and alpha, three R, G, B, four R, G, B, A. Alpha is not multiplied
/// in, but for EXR files, which are taken as they stand. Floats are finite.
struct Texels {
  int width = 0, height = 0;
  int channels = 0;
  TexelFormat format = TexelFormat::u8;
  std::vector<std::byte> bytes;

  [[nodiscard]] std::size_t row_bytes() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(channels) * bytes_of(format);
  }
};

/// Bytes that several pictures may take together. Several threads may take at once.
class TexelBudget {
 public:
  explicit TexelBudget(std::uint64_t most) : most_(most), left_(most) {}
  /// Throws Error{too_large} at `name` if so many are not left.
  void take(std::uint64_t bytes, const std::string& name);

 private:
  std::uint64_t most_;
  std::atomic<std::uint64_t> left_;
};

/// PNG (1 to 16 bits), JPEG, WebP, TGA, Radiance HDR or OpenEXR, told from the first bytes. Colour
/// profiles and gamma in them are not looked at. Throws Error at `name`: bad_input for a format
/// that is none of these or a file that is broken or cut short, too_large for a picture beyond
/// limits.hpp or `budget`, before memory is taken for it.
Texels decode_texels(std::span<const std::byte> file, const std::string& name,
                     TexelBudget* budget = nullptr);

}  // namespace tessera::image
