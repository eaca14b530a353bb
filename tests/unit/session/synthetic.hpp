#pragma once
#include <cstdint>

#include "common/image/picture.hpp"
#include "common/image/tile.hpp"
#include "common/job/job_spec.hpp"
#include "server/coordinator/frame_film.hpp"
#include "server/film/film.hpp"

/// Tiles that no renderer made, and the frame that they must add up to.
namespace tessera::server {

/// Values that depend on the task, the pixel and the channel alone.
inline image::TileImage synthetic_tile(const JobPlan& plan, const TaskId& task) {
  const image::TileExpectation expected = expectation_of(plan, task);
  image::TileImage tile;
  tile.window = expected.window;
  tile.film_width = expected.film_width;
  tile.film_height = expected.film_height;
  tile.samples = {expected.samples, expected.aovs ? expected.samples : 0};
  std::uint64_t state = std::hash<TaskId>()(task) | 1;
  for (std::size_t i = 0; i < tile.channels() * tile.pixels(); ++i) {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    tile.values.push_back(static_cast<float>(state >> 40) / 16777216.0F);
  }
  return tile;
}

/// Every pass of every tile, folded one after another.
inline FilmSnapshot straight_fold(const JobPlan& plan, std::int32_t frame) {
  Film film(plan.grid);
  for (std::uint32_t tile = 0; tile < plan.grid.count(); ++tile)
    for (std::uint32_t pass = 0; pass < plan.passes.count(); ++pass)
      film.fold(tile, synthetic_tile(plan, {frame, tile, pass}));
  return film.snapshot();
}

inline image::ExrImage expected_exr(const JobPlan& plan, std::int32_t frame) {
  return image::read_exr(image::encode_exr(resolve(straight_fold(plan, frame)), image::Metadata()));
}

}  // namespace tessera::server
