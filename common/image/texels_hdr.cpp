#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>

#include "common/image/texels_decode.hpp"

namespace tessera::image {

namespace {

/// Radiance's picture files (Ward, "Real Pixels", Graphics Gems II, 1991): lines of text, then rows
/// of R, G, B and a common exponent, packed by components or, in old files, by texels.
class HdrReader {
 public:
  HdrReader(std::span<const std::byte> file, const PictureSource& source)
      : file_(file), source_(source) {}

  Texels read() {
    read_header();
    Texels out = picture_of(width_, height_, 3, TexelFormat::f32, source_, least_bytes(),
                            file_.size() - at_);
    std::vector<Code> row(static_cast<std::size_t>(width_));
    for (std::int64_t y = 0; y < height_; ++y) {
      read_row(row);
      std::byte* to = out.bytes.data() + static_cast<std::size_t>(y) * out.row_bytes();
      for (const Code& code : row) {
        // (c + ½)·2^(e − 136) is Radiance's own; most readers take c·2^(e − 136), and so do we.
        const float scale = code[3] == 0 ? 0.0F : std::ldexp(1.0F, static_cast<int>(code[3]) - 136);
        for (std::size_t c = 0; c < 3; ++c) {
          const float value = tamed(static_cast<float>(code[c]) * scale, float_most);
          std::memcpy(to, &value, sizeof value);
          to += sizeof value;
        }
      }
    }
    return out;
  }

 private:
  using Code = std::array<std::uint8_t, 4>;

  [[noreturn]] void refuse(std::string_view why) const {
    refuse_picture(source_.name, fmt::format("not a valid HDR file: {}", why));
  }
  std::uint8_t next() {
    if (at_ >= file_.size()) refuse("the file ends too early");
    return std::to_integer<std::uint8_t>(file_[at_++]);
  }
  Code next_code() {
    Code code;
    for (std::uint8_t& byte : code) byte = next();
    return code;
  }

  std::string line() {
    constexpr std::size_t longest = 1024;
    std::string out;
    for (char c = 0; (c = static_cast<char>(next())) != '\n';) {
      if (out.size() == longest) refuse("its header has a line without an end");
      out += c;
    }
    return out;
  }

  void read_header() {
    constexpr int most_lines = 1024;
    std::string text = line();
    for (int count = 0; !text.empty(); ++count) {
      if (count == most_lines) refuse("its header does not end");
      if (text.starts_with("FORMAT=") && text != "FORMAT=32-bit_rle_rgbe")
        refuse(fmt::format("expected FORMAT=32-bit_rle_rgbe, found {}", text.substr(0, 60)));
      text = line();
    }
    const std::string size = line();
    // Rows from the top, from left to right: what all tools write.
    if (!size.starts_with("-Y ")) refuse("expected a size as in \"-Y 512 +X 1024\"");
    const char* const last = size.data() + size.size();
    const auto height = std::from_chars(size.data() + 3, last, height_);
    const std::string_view rest(height.ptr, static_cast<std::size_t>(last - height.ptr));
    if (height.ec != std::errc() || !rest.starts_with(" +X "))
      refuse("expected a size as in \"-Y 512 +X 1024\"");
    const auto width = std::from_chars(height.ptr + 4, last, width_);
    if (width.ec != std::errc() || width.ptr != last)
      refuse("expected a size as in \"-Y 512 +X 1024\"");
  }

  /// A row's first texel, and two repetitions: one of up to 255 texels, one of any number.
  [[nodiscard]] std::uint64_t least_bytes() const {
    const std::uint64_t codes = width_ == 1 ? 1 : width_ <= 256 ? 2 : 3;
    return static_cast<std::uint64_t>(std::max<std::int64_t>(height_, 0)) * codes * sizeof(Code);
  }

  void read_row(std::vector<Code>& row) {
    const Code first = next_code();
    const bool by_components =
        row.size() >= 8 && row.size() < 32768 && first[0] == 2 && first[1] == 2 && first[2] < 128;
    if (!by_components) return read_old_row(first, row);
    if (static_cast<std::size_t>(first[2]) * 256 + first[3] != row.size())
      refuse("a row of another width");
    for (std::size_t c = 0; c < 4; ++c) {
      for (std::size_t x = 0; x < row.size();) {
        std::size_t count = next();
        const bool run = count > 128;
        if (run) count -= 128;
        if (count == 0 || count > row.size() - x) refuse("a run beyond its row");
        std::uint8_t value = run ? next() : std::uint8_t{0};
        for (std::size_t i = 0; i < count; ++i) {
          if (!run) value = next();
          row[x++][c] = value;
        }
      }
    }
  }

  /// Texels one by one; 1, 1, 1, n repeats the last n times, and a further such code counts 256
  /// times as much.
  void read_old_row(Code code, std::vector<Code>& row) {
    unsigned shift = 0;
    for (std::size_t x = 0;;) {
      if (code[0] == 1 && code[1] == 1 && code[2] == 1) {
        const std::size_t count = static_cast<std::size_t>(code[3]) << shift;
        if (x == 0 || shift > 16 || count > row.size() - x) refuse("a run beyond its row");
        for (std::size_t i = 0; i < count; ++i, ++x) row[x] = row[x - 1];
        shift += 8;
      } else {
        row[x++] = code;
        shift = 0;
      }
      if (x == row.size()) return;
      code = next_code();
    }
  }

  std::span<const std::byte> file_;
  const PictureSource& source_;
  std::size_t at_ = 0;
  std::int64_t width_ = 0, height_ = 0;
};

}  // namespace

Texels decode_hdr(std::span<const std::byte> file, const PictureSource& source) {
  return HdrReader(file, source).read();
}

}  // namespace tessera::image
