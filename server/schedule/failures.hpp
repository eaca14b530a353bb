#pragma once
#include <string>

#include "server/schedule/worker_entry.hpp"

/// Failed attempts in words, for people.
namespace tessera::server {

inline AttemptFailed attempt_failed(const WorkerEntry& worker, const HeldLease& held,
                                    AttemptFailed::Outcome outcome, const std::string& reason) {
  return {held.job, held.task, held.id, worker.id, worker.info.name, outcome, reason, held.granted};
}

/// The attempt to build a job's scene.
inline AttemptFailed preparation_failed(const WorkerEntry& worker, JobId job,
                                        AttemptFailed::Outcome outcome, const std::string& reason) {
  AttemptFailed failed;
  failed.job = job;
  failed.worker = worker.id;
  failed.worker_name = worker.info.name;
  failed.outcome = outcome;
  failed.reason = reason;
  if (const auto part = worker.parts.find(job); part != worker.parts.end())
    failed.granted = part->second.begun;
  return failed;
}

}  // namespace tessera::server
