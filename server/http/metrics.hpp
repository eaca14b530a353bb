#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "server/coordinator/coordinator.hpp"
#include "server/http/api.hpp"

namespace tessera::server {

struct ProcessUsage {
  double cpu_seconds = 0;  ///< user and system
  std::uint64_t resident_bytes = 0;
  std::uint64_t peak_resident_bytes = 0;
  std::uint64_t open_files = 0;
};
/// Of this process, from the kernel.
ProcessUsage process_usage();

/// What /metrics shows: the Prometheus text format, version 0.0.4. Pure.
std::string metrics_text(const std::vector<JobStatus>& jobs, const std::vector<WorkerView>& workers,
                         const CoordinatorCounters& coordinator, const StorageUse& storage,
                         const HttpCounters& http, const ProcessUsage& process);

}  // namespace tessera::server
