#pragma once
#include <functional>
#include <optional>
#include <queue>
#include <utility>
#include <vector>

#include "server/schedule/worker_entry.hpp"

namespace tessera::server {

/// When each worker is next to be looked at. Being heard only moves a deadline away, so nothing is
/// done then: the entry is looked at when it comes up, and put back.
class Timers {
 public:
  /// Makes sure that the worker is looked at no later than it is due.
  void arm(WorkerEntry& worker, Instant due) {
    if (worker.timer && *worker.timer <= due) return;
    worker.timer = due;
    queue_.emplace(due, worker.id);
  }
  [[nodiscard]] std::optional<Instant> next() const {
    return queue_.empty() ? std::nullopt : std::optional(queue_.top().first);
  }
  /// A worker whose instant has come; an entry counts only while it is its worker's `timer`.
  std::optional<std::pair<Instant, WorkerId>> pop(Instant now) {
    if (queue_.empty() || queue_.top().first > now) return std::nullopt;
    const auto entry = queue_.top();
    queue_.pop();
    return entry;
  }

 private:
  using Entry = std::pair<Instant, WorkerId>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_;
};

}  // namespace tessera::server
