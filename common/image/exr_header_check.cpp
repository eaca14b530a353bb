#include "common/image/exr_header_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "common/base/error.hpp"
#include "common/image/exr_layout.hpp"

namespace tessera::image {

namespace {

struct FixedSize {
  std::string_view type;
  std::size_t bytes;
};
/// Strings, vectors of them and of floats, and types that are not known have the length they say.
constexpr std::array<FixedSize, 24> fixed_sizes{
    {{"box2i", 16},      {"box2f", 16},    {"chromaticities", 32},
     {"compression", 1}, {"double", 8},    {"deepImageState", 1},
     {"envmap", 1},      {"float", 4},     {"int", 4},
     {"keycode", 28},    {"lineOrder", 1}, {"m33f", 36},
     {"m33d", 72},       {"m44f", 64},     {"m44d", 128},
     {"rational", 8},    {"v2i", 8},       {"v2f", 8},
     {"v2d", 16},        {"v3i", 12},      {"v3f", 12},
     {"v3d", 24},        {"tiledesc", 9},  {"timecode", 8}}};

/// Bytes that are taken from the front.
class Walk {
 public:
  Walk(std::span<const std::byte> rest, const std::string& name) : rest_(rest), name_(name) {}

  void headers() {
    constexpr std::size_t flags_at = 5;
    constexpr std::byte many_parts{0x10};
    const bool many = (take(8)[flags_at] & many_parts) != std::byte{0};
    do {
      for (std::string_view key = text(); !key.empty(); key = text()) attribute(key);
    } while (many && !rest_.empty() && rest_[0] != std::byte{0});
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorKind::bad_input, "not a valid EXR file: " + what, {.file = name_});
  }
  std::span<const std::byte> take(std::size_t count) {
    if (count > rest_.size()) fail("its header is cut off");
    const std::span<const std::byte> out = rest_.first(count);
    rest_ = rest_.subspan(count);
    return out;
  }
  std::string_view text() {
    constexpr std::size_t longest = 255;
    const std::size_t most = std::min(longest + 1, rest_.size());
    const std::string_view ahead(reinterpret_cast<const char*>(rest_.data()), most);
    const std::size_t end = ahead.find('\0');
    if (end == std::string_view::npos) fail("its header has a name without an end");
    (void)take(end + 1);
    return ahead.substr(0, end);
  }
  std::uint32_t number() {
    std::uint32_t value = 0;
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    return value;
  }

  void attribute(std::string_view key) {
    const std::string_view type = text();
    const std::uint32_t size = number();
    if (size > rest_.size())
      fail(fmt::format("attribute {} says {} bytes, and {} are left", printable(key), size,
                       rest_.size()));
    if (Walk(take(size), name_).length_of(type) != size)
      fail(fmt::format("attribute {} says {} bytes, which is not what a {} has", printable(key),
                       size, printable(type)));
  }

  /// Bytes that the library takes for a value of this type, of those that are here.
  std::size_t length_of(std::string_view type) {
    const std::size_t here = rest_.size();
    if (type == "chlist") {
      constexpr std::size_t channel_bytes = 16;
      while (!text().empty()) (void)take(channel_bytes);
      return here - rest_.size();
    }
    if (type == "preview") {
      const std::uint64_t width = number(), height = number();
      const std::uint64_t texels = width * height;
      return texels < here ? 8 + 4 * texels : 0;
    }
    if (type == "idmanifest") fail("an ID manifest, which is not read");
    const auto* const known = std::find_if(fixed_sizes.begin(), fixed_sizes.end(),
                                           [&](const FixedSize& one) { return one.type == type; });
    return known == fixed_sizes.end() ? here : known->bytes;
  }

  std::span<const std::byte> rest_;
  const std::string& name_;
};

}  // namespace

void check_exr_header(std::span<const std::byte> exr, const std::string& name) {
  Walk(exr, name).headers();
}

}  // namespace tessera::image
