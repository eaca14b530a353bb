#include "tests/sim/synthetic.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "server/film/noise.hpp"
#include "server/schedule/noise_stop.hpp"

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
  const auto table = image::default_layout()->channels();
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

Bytes bytes_of(const image::TileImage& tile) {
  auto bytes = std::make_shared<std::vector<std::byte>>();
  bytes->resize(sizeof tile.samples + tile.values.size() * sizeof(float));
  std::memcpy(bytes->data(), tile.samples.data(), sizeof tile.samples);
  std::memcpy(bytes->data() + sizeof tile.samples, tile.values.data(),
              tile.values.size() * sizeof(float));
  return bytes;
}

server::DecodedTile decode(const Bytes& bytes, const JobPlan& plan, const TaskId& task) {
  server::DecodedTile decoded;
  image::TileView& view = decoded.pixels;
  require(bytes->size() >= sizeof view.samples, "a kept tile is whole");
  std::memcpy(view.samples.data(), bytes->data(), sizeof view.samples);
  view.window = plan.grid.tile(task.tile);
  view.film_width = plan.spec.render.width;
  view.film_height = plan.spec.render.height;
  require(bytes->size() == sizeof view.samples + view.channels() * sizeof(float) &&
              view.samples[0] == plan.passes.pass(task.pass).count,
          "a kept tile is its task's");
  view.lines = {bytes->data() + sizeof view.samples};
  view.offset_of.resize(image::channel_count);
  for (std::size_t channel = 0; channel < image::channel_count; ++channel)
    view.offset_of[channel] = channel * sizeof(float);
  decoded.exr = bytes;
  return decoded;
}

std::vector<std::byte> bytes_of(const server::FilmSnapshot& film) {
  std::vector<std::byte> bytes;
  const auto add = [&](const auto& value) {
    const auto raw = std::as_bytes(std::span(&value, 1));
    bytes.insert(bytes.end(), raw.begin(), raw.end());
  };
  for (const auto& tile : film.tiles) {
    if (!tile) continue;
    add(tile->passes);
    add(tile->samples);
    for (const double sum : tile->sums) add(sum);
  }
  return bytes;
}

std::vector<server::FilmTile> picture_of(std::span<const std::byte> bytes, const JobPlan& plan) {
  std::vector<server::FilmTile> tiles;
  const auto take = [&](auto& value) {
    require(bytes.size() >= sizeof value, "a picture is whole");
    std::memcpy(&value, bytes.data(), sizeof value);
    bytes = bytes.subspan(sizeof value);
  };
  while (!bytes.empty() && tiles.size() < plan.grid.count()) {
    const auto index = static_cast<std::uint32_t>(tiles.size());
    server::FilmTile tile = server::empty_film_tile(plan.grid.tile(index));
    take(tile.passes);
    take(tile.samples);
    for (double& sum : tile.sums) take(sum);
    tiles.push_back(std::move(tile));
  }
  require(bytes.empty(), "a picture has an end");
  return tiles;
}

server::FilmTile straight_fold(const JobPlan& plan, std::int32_t frame, std::uint32_t tile) {
  server::FilmTile film = server::empty_film_tile(plan.grid.tile(tile));
  for (std::uint32_t pass = 0; pass < plan.passes.count(); ++pass)
    server::fold(film, render(plan, {frame, tile, pass}));
  return film;
}

std::uint32_t passes_alone(const JobPlan& plan, std::int32_t frame) {
  server::FilmSnapshot film{plan.grid, 0, {}, {}};
  std::vector<std::shared_ptr<server::FilmTile>> tiles;
  for (std::uint32_t tile = 0; tile < plan.grid.count(); ++tile) {
    tiles.push_back(
        std::make_shared<server::FilmTile>(server::empty_film_tile(plan.grid.tile(tile))));
    film.tiles.push_back(tiles.back());
  }
  for (std::uint32_t pass = 0; pass + 1 < plan.passes.count(); ++pass) {
    for (std::uint32_t tile = 0; tile < plan.grid.count(); ++tile)
      server::fold(*tiles[tile], render(plan, {frame, tile, pass}));
    if (server::noise_is_looked_at(plan.passes, pass + 1) &&
        server::noise_of(film) <= plan.spec.noise_threshold)
      return pass + 1;
  }
  return plan.passes.count();
}

std::vector<double> plain_sums(const JobPlan& plan, std::int32_t frame, std::uint32_t tile) {
  const auto table = image::default_layout()->channels();
  std::vector<double> sums(table.size(), 0.0), squares(table.size(), 0.0);
  std::array<double, image::group_count> samples{};
  for (std::size_t c = 0; c < table.size(); ++c)
    if (table[c].merge == image::Merge::nearest)
      sums[c] = static_cast<double>(image::nothing_hit_z);
  for (std::uint32_t pass = 0; pass < plan.passes.count(); ++pass) {
    const image::TileImage image = render(plan, {frame, tile, pass});
    for (std::size_t group = 0; group < samples.size(); ++group)
      samples[group] += static_cast<double>(image.samples[group]);
    for (std::size_t c = 0; c < image.channels(); ++c) {
      const auto value = static_cast<double>(image.values[c]);
      const auto n = static_cast<double>(image.samples[static_cast<std::size_t>(table[c].group)]);
      if (table[c].merge == image::Merge::nearest) {
        sums[c] = std::min(sums[c], value);
      } else if (table[c].merge == image::Merge::mean) {
        sums[c] += n * value;
        squares[c] += n * value * value;
      } else {
        sums[c] += value;
      }
    }
  }
  // Σ over passes of M2 + n·(mean − mean of all)².
  for (std::size_t c = 0; c < table.size(); ++c) {
    if (table[c].merge != image::Merge::moment2) continue;
    const auto mean = static_cast<std::size_t>(table[c].mean_of);
    const double n = samples[static_cast<std::size_t>(table[c].group)];
    sums[c] += squares[mean] - sums[mean] * sums[mean] / n;
  }
  return sums;
}

}  // namespace tessera::sim
