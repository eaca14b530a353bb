#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/base/clock.hpp"
#include "common/base/digest.hpp"
#include "common/job/job_spec.hpp"
#include "common/job/task.hpp"

/// What the store keeps, as plain values.
namespace tessera::server {

/// Where a result's record stands in the journal. Fixed for good once it has been given out.
struct ResultPlace {
  std::uint64_t segment = 0;
  std::uint64_t offset = 0;  ///< of the record's first byte in the segment's file
  std::uint64_t length = 0;  ///< of the whole record, bytes
  bool operator==(const ResultPlace&) const = default;
};

/// What is kept of a result beside its pixels.
struct ResultInfo {
  JobId job = 0;
  Digest plan;
  TaskId task;
  LeaseId lease;
  std::string identity;  ///< of the worker; at most 255 bytes
  std::int64_t samples = 0;
  std::int64_t rays = 0;
  std::int64_t rejected = 0;
  double seconds = 0;
  double cpu_seconds = 0;
  bool operator==(const ResultInfo&) const = default;
};

/// A result on its way into the journal. `exr` must stay alive during the call.
struct NewResult {
  ResultInfo info;
  std::string worker_name;  ///< for people
  Digest worker_build;      ///< the build that made it: the job's build after a restart
  std::span<const std::byte> exr;
};

/// A result as it is read back.
struct StoredResult {
  ResultInfo info;
  std::vector<std::byte> exr;
};

/// A row of the journal's index: all that a start needs without touching the journal.
struct IndexedResult {
  TaskId task;
  ResultPlace place;
  std::int64_t samples = 0;
  std::int64_t rays = 0;
  std::int64_t rejected = 0;
  double seconds = 0;
  double cpu_seconds = 0;
  std::string identity;
  std::string worker_name;
  Digest worker_build;
};

/// A tile of a checkpoint: which passes are folded into it, [0, passes), and where its record
/// stands in the checkpoint's file.
struct CheckpointTile {
  std::uint32_t tile = 0;
  std::uint32_t passes = 0;
  std::uint64_t offset = 0;
  std::uint64_t length = 0;  ///< of the whole record, bytes
  bool operator==(const CheckpointTile&) const = default;
};

/// A frame's film as it was written whole, to a file of its own. Tiles into which nothing was
/// folded are left out.
struct Checkpoint {
  JobId job = 0;
  std::int32_t frame = 0;
  std::uint64_t number = 0;           ///< names the file; never given twice
  std::uint64_t bytes = 0;            ///< of the file
  std::vector<CheckpointTile> tiles;  ///< ascending by tile
  bool operator==(const Checkpoint&) const = default;
};

/// Where one tile of a checkpoint is read from.
struct CheckpointPlace {
  std::uint64_t number = 0;
  std::uint64_t offset = 0;
  std::uint64_t length = 0;
  bool operator==(const CheckpointPlace&) const = default;
};

/// What one worker's results came to, those that left the index for a checkpoint.
struct Tally {
  std::string worker_name;
  Digest worker_build;
  std::int64_t samples = 0;
  std::int64_t rays = 0;
  std::int64_t rejected = 0;
  double cpu_seconds = 0;
};

/// A job as it is kept. Everything but id may change (but see below), of the spec the samples and
/// what JobChange holds; the state's words are those of JobView.
struct JobRecord {
  JobId id = 0;
  JobSpec spec;
  std::string state = "queued";
  int priority = 0;  ///< spec.priority at first; the one that counts
  UnixMillis created = 0, started = 0, finished = 0;  ///< 0: not yet
  std::string error;
  double render_seconds = 0;
  double cpu_seconds = 0;
  std::int64_t rays = 0;
  std::int64_t rejected_samples = 0;
  struct Share {
    std::string worker;
    std::int64_t samples = 0;
    bool operator==(const Share&) const = default;
  };
  std::vector<Share> shares;  ///< kept for when the results themselves are forgotten
  std::vector<std::int64_t>
      extended_from;                ///< samples asked for before it was extended, oldest first
  std::int64_t shortened_from = 0;  ///< samples asked for, where its time was up before; else 0
  /// Frames of several that ended by their noise: samples of each pixel that they have. Changed by
  /// Store::shorten_frame, unshorten_frame and extend_job alone.
  std::map<std::int32_t, std::int64_t> shortened_frames;
  /// What who posted it called the request, and a digest of what was posted, so that it can be
  /// repeated. Empty: it cannot. They do not change.
  std::string idempotency_key, idempotency_fingerprint;
};

/// Workers of this name are granted nothing until they are released.
struct Quarantine {
  std::string name;
  std::string reason;
  std::string by;        ///< "user": a person said so; "server": it failed where others do not
  UnixMillis since = 0;  ///< Unix time
  bool durable = true;   ///< false: it is in force, and not on disk yet
  bool operator==(const Quarantine&) const = default;
};

/// An attempt at a task of a job that gave no result, as people are told of it.
struct FailureRecord {
  std::uint64_t number = 0;    ///< counts a job's failures from 1; the store's to give
  std::optional<TaskId> task;  ///< lacking: the job's scene was being prepared
  LeaseId lease;               ///< of the task; 0.0 without one
  std::uint64_t worker = 0;
  std::string worker_name;
  std::string outcome;                ///< "lost", "stalled", "failed", "invalid"
  UnixMillis started = 0, ended = 0;  ///< 0: not known
  std::string reason;
  std::string log;  ///< the last lines of the worker's log, if it could say them
  bool operator==(const FailureRecord&) const = default;
};

}  // namespace tessera::server
