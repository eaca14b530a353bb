#include <fmt/format.h>

#include <bit>

#include "common/image/picture.hpp"

namespace tessera::image {

bool is_diagnostic(std::string_view channel) { return channel == "time" || channel == "worker"; }

namespace {

/// The first of `names` that is no diagnostic channel and not in the other picture; empty if there
/// is none.
std::string lacking(const ExrImage& in, const std::vector<std::string>& names) {
  for (const auto& name : names)
    if (!is_diagnostic(name) && !in.has(name)) return name;
  return {};
}

}  // namespace

std::optional<std::string> difference(const ExrImage& a, const ExrImage& b) {
  if (a.width != b.width || a.height != b.height)
    return fmt::format("one picture is {}x{}, the other {}x{}", a.width, a.height, b.width,
                       b.height);
  for (const auto& name : {lacking(a, b.channels), lacking(b, a.channels)})
    if (!name.empty()) return fmt::format("channel {} is in one picture only", name);
  std::size_t different = 0;
  std::string first;
  for (const auto& name : a.channels) {
    if (is_diagnostic(name)) continue;
    const auto left = a.plane(name), right = b.plane(name);
    for (std::size_t i = 0; i < left.size(); ++i) {
      if (std::bit_cast<std::uint32_t>(left[i]) == std::bit_cast<std::uint32_t>(right[i])) continue;
      const auto width = static_cast<std::size_t>(a.width);
      if (++different == 1)
        first = fmt::format("{} at pixel {},{} is {} in one picture and {} in the other", name,
                            i % width, i / width, left[i], right[i]);
    }
  }
  if (different == 0) return std::nullopt;
  return fmt::format("{} ({} values differ)", first, different);
}

}  // namespace tessera::image
