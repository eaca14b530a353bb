#include "server/film/film_tile.hpp"

#include <algorithm>

#include "common/base/error.hpp"

namespace tessera::server {

using image::Channel;
using image::channel_count;
using image::channel_table;
using image::Merge;

namespace {

std::size_t group_index(const Channel& channel) { return static_cast<std::size_t>(channel.group); }

/// Chan, Golub and LeVeque (1979): M2 of the union of two sets, by their sizes, means and M2. Σ of
/// the first set's values is `sum`.
void merge_moment2(std::span<double> m2, std::span<const double> sum, double before,
                   std::span<const float> pass_m2, std::span<const float> pass_mean,
                   double samples) {
  if (before == 0) {
    std::copy(pass_m2.begin(), pass_m2.end(), m2.begin());
    return;
  }
  const double weight = before * samples / (before + samples);
  for (std::size_t i = 0; i < m2.size(); ++i) {
    const double delta = static_cast<double>(pass_mean[i]) - sum[i] / before;
    m2[i] += static_cast<double>(pass_m2[i]) + delta * delta * weight;
  }
}

}  // namespace

FilmTile empty_film_tile(const Rect& window) {
  FilmTile tile;
  tile.window = window;
  tile.sums.assign(channel_count * tile.pixels(), 0.0);
  for (std::size_t c = 0; c < channel_count; ++c)
    if (channel_table()[c].merge == Merge::nearest)
      std::fill_n(tile.sums.begin() + static_cast<std::ptrdiff_t>(c * tile.pixels()), tile.pixels(),
                  static_cast<double>(image::nothing_hit_z));
  return tile;
}

void fold(FilmTile& tile, const image::TileImage& pass) {
  const std::size_t pixels = tile.pixels();
  const bool fits = pass.window == tile.window && pass.values.size() == pass.channels() * pixels &&
                    tile.sums.size() == channel_count * pixels && pass.samples[0] != 0;
  if (!fits)
    throw Error(ErrorKind::failed,
                "a pass does not fit the film's tile that it was to be folded into");
  const auto plane = [&](std::size_t c) {
    return std::span(tile.sums).subspan(c * pixels, pixels);
  };
  const auto travelling = channel_table().first(pass.channels());

  // Second moments first: they need the means as they were before this pass.
  for (std::size_t c = 0; c < travelling.size(); ++c) {
    const Channel& channel = travelling[c];
    if (channel.merge != Merge::moment2) continue;
    const auto mean = static_cast<std::size_t>(channel.mean_of);
    merge_moment2(plane(c), plane(mean), static_cast<double>(tile.samples[group_index(channel)]),
                  pass.plane(c), pass.plane(mean),
                  static_cast<double>(pass.samples[group_index(channel)]));
  }
  for (std::size_t c = 0; c < travelling.size(); ++c) {
    const auto sums = plane(c);
    const auto values = pass.plane(c);
    const auto n = static_cast<double>(pass.samples[group_index(travelling[c])]);
    switch (travelling[c].merge) {
      case Merge::moment2:
        break;
      case Merge::mean:
        for (std::size_t i = 0; i < pixels; ++i) sums[i] += n * static_cast<double>(values[i]);
        break;
      case Merge::nearest:
        for (std::size_t i = 0; i < pixels; ++i)
          sums[i] = std::min(sums[i], static_cast<double>(values[i]));
        break;
    }
  }
  for (std::size_t group = 0; group < image::group_count; ++group)
    tile.samples[group] += pass.samples[group];
  ++tile.passes;
}

double mean_divisor(const FilmTile& tile, std::size_t channel) {
  const Channel& entry = channel_table()[channel];
  const std::uint64_t samples = tile.samples[group_index(entry)];
  return entry.merge == Merge::mean && samples > 0 ? static_cast<double>(samples) : 1.0;
}

std::vector<float> resolve(const FilmTile& tile) {
  const std::size_t pixels = tile.pixels();
  std::vector<float> values(tile.sums.size());
  for (std::size_t c = 0; c < channel_count; ++c) {
    const double divisor = mean_divisor(tile, c);
    for (std::size_t i = c * pixels; i < (c + 1) * pixels; ++i)
      values[i] = static_cast<float>(tile.sums[i] / divisor);
  }
  return values;
}

}  // namespace tessera::server
