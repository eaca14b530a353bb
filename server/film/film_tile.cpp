#include "server/film/film_tile.hpp"

#include <algorithm>
#include <utility>

#include "common/base/error.hpp"
#include "server/film/caught_shadow.hpp"
#include "server/film/fold_mattes.hpp"

namespace tessera::server {

using image::Channel;
using image::Merge;
using image::TileView;

namespace {

std::size_t group_index(const Channel& channel) { return static_cast<std::size_t>(channel.group); }

/// Chan, Golub and LeVeque (1979): M2 of the union of two sets, by their sizes, means and M2. Σ of
/// the first set's values is `sum`.
void merge_moment2(std::span<double> m2, const double* sum, double before,
                   const image::FloatRow& pass_m2, const image::FloatRow& pass_mean,
                   double samples) {
  if (before == 0) {
    for (std::size_t i = 0; i < m2.size(); ++i) m2[i] = static_cast<double>(pass_m2[i]);
    return;
  }
  const double weight = before * samples / (before + samples);
  for (std::size_t i = 0; i < m2.size(); ++i) {
    const double delta = static_cast<double>(pass_mean[i]) - sum[i] / before;
    m2[i] += static_cast<double>(pass_m2[i]) + delta * delta * weight;
  }
}

/// `before`, `n`: samples behind the sums, and behind the values.
void merge_row(Merge merge, std::span<double> sums, const image::FloatRow& values, double before,
               double n) {
  switch (merge) {
    case Merge::moment2:
    case Merge::matte:
    case Merge::matte_weight:
      return;
    case Merge::first:
      if (before > 0) return;
      [[fallthrough]];
    case Merge::total:
      for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += static_cast<double>(values[i]);
      return;
    case Merge::mean:
      for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += n * static_cast<double>(values[i]);
      return;
    case Merge::nearest:
      for (std::size_t i = 0; i < sums.size(); ++i)
        sums[i] = std::min(sums[i], static_cast<double>(values[i]));
      return;
  }
}

/// One channel, row by row: the sums are walked through in the order of memory, which costs less
/// than to walk so through the file's lines, for they are larger.
template <class MergeRow>
void each_row(FilmTile& tile, std::size_t channel, MergeRow merge) {
  const auto width = static_cast<std::size_t>(tile.window.width);
  const auto height = static_cast<std::size_t>(tile.window.height);
  const auto plane = std::span(tile.sums).subspan(channel * tile.pixels(), tile.pixels());
  for (std::size_t y = 0; y < height; ++y) merge(plane.subspan(y * width, width), y);
}

[[noreturn]] void does_not_fit() {
  throw Error(ErrorKind::failed,
              "a pass does not fit the film's tile that it was to be folded into");
}

}  // namespace

FilmTile empty_film_tile(const Rect& window, image::Layout layout) {
  FilmTile tile;
  tile.window = window;
  tile.sums.assign(layout->size() * tile.pixels(), 0.0);
  tile.layout = std::move(layout);
  const std::span<const Channel> channels = tile.layout->channels();
  for (std::size_t c = 0; c < channels.size(); ++c)
    if (channels[c].merge == Merge::nearest)
      std::fill_n(tile.sums.begin() + static_cast<std::ptrdiff_t>(c * tile.pixels()), tile.pixels(),
                  static_cast<double>(image::nothing_hit_z));
  return tile;
}

void fold(FilmTile& tile, const TileView& pass) {
  const bool fits = pass.window == tile.window &&
                    pass.lines.size() == static_cast<std::size_t>(tile.window.height) &&
                    *pass.layout == *tile.layout &&
                    tile.sums.size() == tile.layout->size() * tile.pixels() && pass.samples[0] != 0;
  if (!fits) does_not_fit();
  const auto travelling = tile.layout->channels().first(pass.channels());
  // Second moments first: they need the means as they were before this pass.
  for (std::size_t c = 0; c < travelling.size(); ++c) {
    const Channel& channel = travelling[c];
    if (channel.merge != Merge::moment2) continue;
    const auto mean = static_cast<std::size_t>(channel.mean_of);
    const double* sum = tile.sums.data() + mean * tile.pixels();
    const auto before = static_cast<double>(tile.samples[group_index(channel)]);
    const auto samples = static_cast<double>(pass.samples[group_index(channel)]);
    each_row(tile, c, [&](std::span<double> m2, std::size_t y) {
      merge_moment2(m2, sum + y * m2.size(), before, pass.row(c, y), pass.row(mean, y), samples);
    });
  }
  for (std::size_t c = 0; c < travelling.size(); ++c) {
    const std::size_t group = group_index(travelling[c]);
    const auto before = static_cast<double>(tile.samples[group]);
    const auto samples = static_cast<double>(pass.samples[group]);
    each_row(tile, c, [&](std::span<double> sums, std::size_t y) {
      merge_row(travelling[c].merge, sums, pass.row(c, y), before, samples);
    });
  }
  fold_mattes(tile, pass);
  for (std::size_t group = 0; group < image::group_count; ++group)
    tile.samples[group] += pass.samples[group];
  ++tile.passes;
}

void fold(FilmTile& tile, const image::TileImage& pass) {
  if (pass.values.size() != pass.channels() * pass.pixels()) does_not_fit();
  fold(tile, image::view_of(pass));
}

double mean_divisor(const FilmTile& tile, std::size_t channel) {
  const Channel& entry = (*tile.layout)[channel];
  const std::uint64_t samples = tile.samples[group_index(entry)];
  const bool averaged = entry.merge == Merge::mean || entry.merge == Merge::matte_weight;
  return averaged && samples > 0 ? static_cast<double>(samples) : 1.0;
}

void read_values(const FilmTile& tile, std::size_t channel, std::size_t first,
                 std::span<float> out) {
  if (channel == image::A)
    if (const auto caught = first_caught(*tile.layout))
      return read_alpha(tile, *caught, first, out);
  const double divisor = mean_divisor(tile, channel);
  const double* from = tile.sums.data() + channel * tile.pixels() + first;
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<float>(from[i] / divisor);
}

std::vector<float> resolve(const FilmTile& tile) {
  const std::size_t pixels = tile.pixels();
  std::vector<float> values(tile.sums.size());
  for (std::size_t c = 0; c < tile.layout->size(); ++c)
    read_values(tile, c, 0, std::span(values).subspan(c * pixels, pixels));
  return values;
}

}  // namespace tessera::server
