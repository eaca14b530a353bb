#pragma once
#include <string>

#include "common/base/clock.hpp"
#include "common/base/json.hpp"
#include "server/coordinator/coordinator.hpp"

/// The JSON objects that README.md describes. Pure.
namespace tessera::server {

/// "2026-01-31T12:00:00.000Z".
std::string iso_time(UnixMillis time);
Json job_object(const JobStatus& status);
/// `window`: the tile's pixels.
Json failure_object(const FailureRecord& failure, const TileGrid& grid);
Json quarantine_object(const Quarantine& quarantine);
/// `quarantine` is its name's, if there is one.
Json worker_object(const WorkerView& worker, const Quarantine* quarantine);

}  // namespace tessera::server
