#pragma once
#include <cstdint>

#include "common/image/tile.hpp"
#include "common/job/job_spec.hpp"
#include "server/film/film_tile.hpp"

/// Tiles of one pixel whose samples are a hash of (job's seed, frame, pixel, sample): what a
/// renderer would do, in no time.
namespace tessera::sim {

image::TileImage render(const JobPlan& plan, const TaskId& task);

/// The straight fold: every pass of the tile rendered and folded in order, by nothing but loops.
server::FilmTile straight_fold(const JobPlan& plan, std::int32_t frame, std::uint32_t tile);

/// Σ n·mean of R over all passes in order, without the film's code.
double red_sum(const JobPlan& plan, std::int32_t frame, std::uint32_t tile);

}  // namespace tessera::sim
