#include "server/film/caught_shadow.hpp"

#include <algorithm>

namespace tessera::server {

std::optional<std::size_t> first_caught(const image::ChannelLayout& layout) {
  for (const image::AovPlanes& aov : layout.aovs())
    if (aov.use.aov == Aov::shadow_catcher) return aov.first;
  return std::nullopt;
}

void read_alpha(const FilmTile& tile, std::size_t caught, std::size_t first, std::span<float> out) {
  const double samples = mean_divisor(tile, image::A);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const auto sum = [&](std::size_t channel) {
      return tile.sums[channel * tile.pixels() + first + i];
    };
    const auto luminance = [&](std::size_t red) {
      return 0.2126 * sum(caught + red) + 0.7152 * sum(caught + red + 1) +
             0.0722 * sum(caught + red + 2);
    };
    const double open = luminance(unshadowed_R);
    const double lit = open > 0 ? std::clamp(luminance(caught_R) / open, 0.0, 1.0) : 1.0;
    const double dark = sum(caught + caught_coverage) * (1 - lit);
    out[i] = static_cast<float>(std::min((sum(image::A) + dark) / samples, 1.0));
  }
}

}  // namespace tessera::server
