#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/image/tile.hpp"
#include "common/job/job_spec.hpp"
#include "server/coordinator/frame_film.hpp"
#include "server/film/film_tile.hpp"
#include "tests/sim/ledger.hpp"

/// Tiles of one pixel whose samples are a hash of (job's seed, frame, pixel, sample): what a
/// renderer would do, in no time.
namespace tessera::sim {

image::TileImage render(const JobPlan& plan, const TaskId& task);

/// The tile as it travels and is kept: n of each group, then the values.
Bytes bytes_of(const image::TileImage& tile);
/// The same, to be folded. Throws Violation if they are not of this task.
server::DecodedTile decode(const Bytes& bytes, const JobPlan& plan, const TaskId& task);

/// A frame's picture as it is kept.
std::vector<std::byte> bytes_of(const server::FilmSnapshot& film);
std::vector<server::FilmTile> picture_of(std::span<const std::byte> bytes, const JobPlan& plan);

/// The straight fold: every pass of the tile rendered and folded in order, by nothing but loops.
server::FilmTile straight_fold(const JobPlan& plan, std::int32_t frame, std::uint32_t tile);

/// Passes with which the frame's noise ends it, looked at as server/schedule/noise_stop.hpp says,
/// where it is rendered by itself and nothing goes wrong; all of them if it does not.
std::uint32_t passes_alone(const JobPlan& plan, std::int32_t frame);

/// What a tile of one pixel holds of each channel after all its passes, without the film's code:
/// Σ n·mean in order, the least, and of the sums of squared deviations what the definition gives.
std::vector<double> plain_sums(const JobPlan& plan, std::int32_t frame, std::uint32_t tile);

}  // namespace tessera::sim
