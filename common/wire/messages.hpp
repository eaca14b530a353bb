#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/base/digest.hpp"
#include "common/job/job_spec.hpp"
#include "common/job/task.hpp"

/// What worker and coordinator say to each other. Plain values; codec.hpp turns them into frames
/// and back. W→C: worker to coordinator; C→W: the other way.
namespace tessera::wire {

/// Both sides must speak the same; a newer peer of the same version may add header keys, which are
/// ignored.
constexpr std::uint16_t protocol_version = 1;

/// W→C, the first message. Anything else before it ends the connection.
struct Hello {
  std::string token;  ///< empty where none is needed
  std::string name;   ///< for people; not unique
  std::string
      identity;  ///< 32 hex digits, made once per worker process; the same when it comes back
  int threads = 0;
  Digest build_id;      ///< of all that may change a sample's bits
  std::string version;  ///< the release, for people
};

/// C→W, the answer to a good hello.
struct Welcome {
  std::uint64_t worker = 0;  ///< the coordinator's number for this identity
  std::uint64_t epoch = 0;   ///< counts the coordinator's starts
  int heartbeat_ms = 1000;   ///< say something at least this often
  std::string blob_url;      ///< e.g. "http://host:8420"; blobs are at {blob_url}/v1/blobs/{sha256}
  std::string blob_token;    ///< shown as a bearer token when fetching blobs; may be empty
};

/// C→W, the answer to a hello that cannot be taken; the connection ends.
struct Refused {
  std::string code;    ///< "token", "version", "build", "full", "quarantined", "protocol"
  std::string reason;  ///< a sentence for people
};

/// C→W: a lease. `spec`, as for_workers() has it, stands in the first lease of a job on a
/// connection.
struct Assign {
  LeaseId lease;
  JobId job = 0;
  Digest plan;
  TaskId task;
  std::optional<JobSpec> spec;
};

/// W→C: fetching the job's blobs or building its scene. Sent again at least every heartbeat while
/// it lasts.
struct Preparing {
  JobId job = 0;
  double fraction = 0;  ///< 0…1
};

/// W→C: the job's scene is built; the clocks of its leases start.
struct Ready {
  JobId job = 0;
};

/// What the folder holds in which a worker keeps scenes' files.
struct CacheUse {
  std::uint64_t bytes = 0;
  std::uint64_t most = 0;       ///< bytes, beyond which the least recently used go
  std::uint64_t evictions = 0;  ///< files that went, since the worker's start
};

/// W→C, the heartbeat: how far each running lease is.
struct Progress {
  struct Running {
    LeaseId lease;
    double fraction = 0;  ///< 0…1
  };
  std::vector<Running> running;
  std::optional<CacheUse> cache;  ///< once it is known
};

/// C→W: do not render these any more. Without leases it only tells the worker's people why it is
/// granted none, or that it is again.
struct Revoke {
  std::vector<LeaseId> leases;
  std::string reason;
};

/// W→C; the body is the tile as EXR.
struct Result {
  LeaseId lease;
  JobId job = 0;
  Digest plan;
  TaskId task;
  std::int64_t samples = 0;   ///< of the whole tile: pixels × samples of the pass
  std::int64_t rays = 0;      ///< traced, closest hits and shadow rays
  std::int64_t rejected = 0;  ///< samples that were NaN or Inf and count as black
  double seconds = 0;         ///< of rendering, wall clock
  double cpu_seconds = 0;
};

/// C→W: the result is durable; the worker may forget it.
struct Accepted {
  LeaseId lease;
};
/// C→W: the task is closed, or the job is gone; the worker may forget the result.
struct Stale {
  LeaseId lease;
};
/// C→W: the result is not what the task asked for, and will not be taken.
struct Rejected {
  LeaseId lease;
  std::string reason;
};

/// W→C: the task, or the whole job's scene, could not be rendered.
struct Failed {
  JobId job = 0;
  std::optional<LeaseId> lease;  ///< lacking: the job's scene could not be built or fetched; all
                                 ///< its leases are given back
  std::string code;    ///< "scene", "fetch", "memory", "render"; "files": the job names files by
                       ///< path that this worker cannot read, and others may
  std::string reason;  ///< a sentence with the place
  std::string log;     ///< the last lines of the worker's log; may be empty
};

/// C→W: finish what runs, deliver it and leave; W→C: please send nothing more, I shall leave.
struct Drain {
  std::string reason;
};

/// Either way, the last message: a clean end. Leases still held are given back without blame.
struct Bye {
  std::string reason;
};

using Message = std::variant<Hello, Welcome, Refused, Assign, Preparing, Ready, Progress, Revoke,
                             Result, Accepted, Stale, Rejected, Failed, Drain, Bye>;

/// The u16 message type on the wire is the alternative's index + 1; the order above is part of the
/// protocol.
std::uint16_t type_of(const Message& message);

}  // namespace tessera::wire
