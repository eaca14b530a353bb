#include <benchmark/benchmark.h>

#include <cmath>
#include <random>

#include "common/image/picture.hpp"
#include "common/image/tile.hpp"
#include "server/film/film.hpp"

/// What the coordinator does with a result and a picture, piece by piece.
namespace {

using namespace tessera;

/// Noise about a smooth picture, as a renderer's is: mantissas are random, exponents are not.
image::TileImage tile_of(int side, bool aovs, unsigned seed = 1) {
  image::TileImage tile{.window = {0, 0, side, side},
                        .film_width = 512,
                        .film_height = 512,
                        .samples = {16, aovs ? 16U : 0U},
                        .values = {}};
  tile.values.resize(tile.channels() * tile.pixels());
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(0.5F, 1);
  for (float& value : tile.values) value = uniform(random);
  return tile;
}

image::TileExpectation expected_of(const image::TileImage& tile) {
  return {tile.window, tile.film_width, tile.film_height, tile.samples[0], tile.has_aovs()};
}

void encode_tile(benchmark::State& state) {
  const auto tile = tile_of(static_cast<int>(state.range(0)), state.range(1) != 0);
  for (auto _ : state) benchmark::DoNotOptimize(image::encode_tile(tile));
}

void decode_tile(benchmark::State& state) {
  const auto tile = tile_of(static_cast<int>(state.range(0)), state.range(1) != 0);
  const auto exr = image::encode_tile(tile);
  const auto expected = expected_of(tile);
  for (auto _ : state) benchmark::DoNotOptimize(image::decode_tile(exr, expected));
}

void fold_in_place(benchmark::State& state) {
  const auto tile = tile_of(static_cast<int>(state.range(0)), state.range(1) != 0);
  server::FilmTile film = server::empty_film_tile(tile.window);
  for (auto _ : state) {
    server::fold(film, tile);
    benchmark::DoNotOptimize(film.sums.data());
  }
}

void fold_into_a_copy(benchmark::State& state) {
  const auto tile = tile_of(static_cast<int>(state.range(0)), state.range(1) != 0);
  std::shared_ptr<const server::FilmTile> film = server::folded(nullptr, tile);
  for (auto _ : state) film = server::folded(film.get(), tile);
}

server::FilmSnapshot film_512() {
  server::Film film(TileGrid(512, 512, 64));
  for (std::uint32_t i = 0; i < film.grid().count(); ++i) {
    auto tile = tile_of(64, true, i);
    tile.window = film.grid().tile(i);
    film.fold(i, tile);
    film.fold(i, tile);
  }
  return film.snapshot();
}

void resolve_512(benchmark::State& state) {
  const auto film = film_512();
  for (auto _ : state) benchmark::DoNotOptimize(server::resolve(film));
}

void encode_exr_512(benchmark::State& state) {
  const auto frame = server::resolve(film_512());
  const auto compression = state.range(0) != 0 ? image::Compression::zip : image::Compression::none;
  std::size_t bytes = 0;
  for (auto _ : state) bytes = image::encode_exr(frame, {}, compression).size();
  state.counters["MB"] = static_cast<double>(bytes) / 1e6;
}

void encode_png_512(benchmark::State& state) {
  const auto film = film_512();
  std::size_t bytes = 0;
  for (auto _ : state) bytes = image::encode_png(512, 512, server::resolve_rgba(film)).size();
  state.counters["MB"] = static_cast<double>(bytes) / 1e6;
}

void changed_tiles_512(benchmark::State& state) {
  const auto film = film_512();
  for (auto _ : state) benchmark::DoNotOptimize(server::encode_changed_tiles(film, 0));
}

BENCHMARK(encode_tile)->ArgNames({"side", "aovs"})->Args({64, 1})->Args({64, 0})->Args({16, 0});
BENCHMARK(decode_tile)->ArgNames({"side", "aovs"})->Args({64, 1})->Args({64, 0})->Args({16, 0});
BENCHMARK(fold_in_place)->ArgNames({"side", "aovs"})->Args({64, 1})->Args({64, 0})->Args({16, 0});
BENCHMARK(fold_into_a_copy)
    ->ArgNames({"side", "aovs"})
    ->Args({64, 1})
    ->Args({64, 0})
    ->Args({16, 0});
BENCHMARK(resolve_512)->Unit(benchmark::kMillisecond);
BENCHMARK(encode_exr_512)->ArgNames({"zip"})->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);
BENCHMARK(encode_png_512)->Unit(benchmark::kMillisecond);
BENCHMARK(changed_tiles_512)->Unit(benchmark::kMillisecond);

}  // namespace
