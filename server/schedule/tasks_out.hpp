#pragma once
#include <cstddef>
#include <set>
#include <unordered_map>
#include <utility>
#include <vector>

#include "common/base/clock.hpp"
#include "common/job/task.hpp"
#include "server/schedule/actions.hpp"

namespace tessera::server {

/// Which lease a task is out under.
struct Holder {
  WorkerId worker = 0;
  LeaseId lease;
};

/// The tasks of one job that are out: who holds each, one lease or several (copies), and when the
/// first of them is expected to be done. The latest come first where copies are looked for. A call
/// costs O(log tasks out) at most.
class TasksOut {
 public:
  /// A task whose end is not known counts as the latest of all.
  static constexpr Instant unknown = Instant::max();

  [[nodiscard]] bool contains(const TaskId& task) const { return out_.contains(task); }
  [[nodiscard]] bool empty() const { return out_.empty(); }
  [[nodiscard]] std::size_t size() const { return out_.size(); }
  /// Oldest first; empty if the task is not out.
  [[nodiscard]] const std::vector<Holder>& holders(const TaskId& task) const;

  /// What is expected of the task is to be said anew after either.
  void add(const TaskId& task, const Holder& holder);
  void remove(const TaskId& task, const LeaseId& lease);
  void clear();

  void expect(const TaskId& task, Instant end);
  /// No copy of it is wanted until something of it changes.
  void unlist(const TaskId& task);
  /// By expected end; of what is out and may be wanted once more.
  [[nodiscard]] const std::set<std::pair<Instant, TaskId>>& by_end() const { return by_end_; }

 private:
  struct Out {
    std::vector<Holder> holders;
    Instant end = unknown;
  };
  // Looked up, never walked through: its order is not determined.
  std::unordered_map<TaskId, Out> out_;
  std::set<std::pair<Instant, TaskId>> by_end_;
};

}  // namespace tessera::server
