#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "common/job/job_spec.hpp"
#include "server/film/film.hpp"
#include "server/store/store.hpp"

/// What the store holds of a job that goes on: read on any thread, taken in on the I/O thread.
namespace tessera::server {

struct JobContent {
  /// By frame, tile, pass: results that are in no checkpoint.
  std::vector<std::pair<TaskId, ResultPlace>> results;
  std::vector<Checkpoint> checkpoints;  ///< by frame
  std::vector<Tally> tallies;           ///< of all, also of what is in checkpoints
};

/// Blocks on the disk. Throws Error.
JobContent read_job(const Store& store, JobId job);

/// Reads through all that the job has: throws DamagedError if any of it is damaged, Error if it
/// cannot be read, or once `stopped` says so. Blocks.
void check_readable(const Store& store, const JobContent& content,
                    const std::function<bool()>& stopped);

/// Writes a checkpoint of a finished frame's regular passes, or of those of them that it has, from
/// its checkpoint so far and the journal; nullopt if it has one of all of them already. Blocks.
/// Throws DamagedError if what is kept of the frame is damaged or not all there: no later attempt
/// goes better. Throws Error if it cannot be read or written, or once `stopped` says so.
struct SettleInput {
  JobId job = 0;
  std::int32_t frame = 0;
  std::shared_ptr<const JobPlan> plan;
  std::uint32_t passes = 0;  ///< that the frame has
};
std::optional<Checkpoint> settle(const Store& store, const SettleInput& input,
                                 const std::function<bool()>& stopped);

/// … of a film that is in memory, as far as it is. No tile of it holds more than the regular
/// passes.
Checkpoint write_checkpoint(const Store& store, JobId job, std::int32_t frame,
                            const FilmSnapshot& film);

}  // namespace tessera::server
