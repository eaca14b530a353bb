#include "tests/sim/synthetic.hpp"

#include <algorithm>
#include <array>

namespace tessera::sim {
namespace {

std::uint64_t mixed(std::uint64_t value) {
  value = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9ULL;
  value = (value ^ (value >> 27)) * 0x94d049bb133111ebULL;
  return value ^ (value >> 31);
}

}  // namespace

image::TileImage render(const JobPlan& plan, const TaskId& task) {
  const SampleRange range = plan.passes.pass(task.pass);
  image::TileImage tile;
  tile.window = plan.grid.tile(task.tile);
  tile.film_width = plan.spec.render.width;
  tile.film_height = plan.spec.render.height;
  const auto samples = static_cast<std::uint32_t>(range.count);
  const bool aovs = plan.passes.has_aovs(task.pass, plan.spec.aov_samples);
  tile.samples = {samples, aovs ? samples : 0};
  tile.values.resize(tile.channels() * tile.pixels());

  const std::uint64_t base =
      mixed(plan.spec.render.seed ^
            mixed((std::uint64_t{static_cast<std::uint32_t>(task.frame)} << 32) | task.tile));
  const auto table = image::channel_table();
  std::array<double, image::channel_count> mean{}, moment{}, least{};
  least.fill(image::nothing_hit_z);
  for (std::int64_t i = 0; i < range.count; ++i) {
    const std::uint64_t sample = mixed(base + static_cast<std::uint64_t>(range.first + i));
    for (std::size_t channel = 0; channel < tile.channels(); ++channel) {
      if (table[channel].merge == image::Merge::moment2) continue;
      // Values whose sums depend on the order in which they are added.
      const double value = static_cast<double>(mixed(sample + channel) >> 40) * 0x1p-24 *
                           ((sample & 63) == 0 ? 1e4 : 1);
      const double delta = value - mean[channel];
      mean[channel] += delta / static_cast<double>(i + 1);
      moment[channel] += delta * (value - mean[channel]);
      least[channel] = std::min(least[channel], value);
    }
  }
  for (std::size_t channel = 0; channel < tile.channels(); ++channel) {
    double value = mean[channel];
    if (table[channel].merge == image::Merge::moment2)
      value = moment[static_cast<std::size_t>(table[channel].mean_of)];
    if (table[channel].merge == image::Merge::nearest) value = least[channel];
    tile.values[channel] = static_cast<float>(value);
  }
  return tile;
}

server::FilmTile straight_fold(const JobPlan& plan, std::int32_t frame, std::uint32_t tile) {
  server::FilmTile film = server::empty_film_tile(plan.grid.tile(tile));
  for (std::uint32_t pass = 0; pass < plan.passes.count(); ++pass)
    server::fold(film, render(plan, {frame, tile, pass}));
  return film;
}

double red_sum(const JobPlan& plan, std::int32_t frame, std::uint32_t tile) {
  double sum = 0;
  for (std::uint32_t pass = 0; pass < plan.passes.count(); ++pass) {
    const image::TileImage image = render(plan, {frame, tile, pass});
    sum += static_cast<double>(image.samples[0]) * static_cast<double>(image.values[image::R]);
  }
  return sum;
}

}  // namespace tessera::sim
