#pragma once
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/job/task.hpp"

namespace tessera::server {

/// What is held against a task: workers that were lost while they ran it, and workers that could
/// not render it.
struct Charges {
  std::set<std::string> lost;        ///< identities that were lost while it ran beside others
  std::set<std::string> lost_alone;  ///< … while it ran alone in its worker
  std::set<std::string> lost_names;  ///< of the workers of both
  std::set<std::string> erred;       ///< identities that said an error, or sent what it is not
  std::set<LeaseId> invalid;         ///< whose result was not valid; not looked at twice
  int errors = 0;                    ///< how often, in all
  [[nodiscard]] bool none() const { return lost.empty() && lost_alone.empty() && erred.empty(); }
};

/// The suspects among a job's tasks. A suspect is set aside, waits here, and is given to a worker
/// that holds nothing else.
class BlameTable {
 public:
  /// The task's charges, made if there are none.
  Charges& charge(const TaskId& task) { return charges_[task]; }
  [[nodiscard]] const Charges* find(const TaskId& task) const;
  [[nodiscard]] bool suspect(const TaskId& task) const { return charges_.contains(task); }

  /// The suspect waits for a worker; no longer.
  void wait(const TaskId& task) { waiting_.insert(task); }
  void taken(const TaskId& task) { waiting_.erase(task); }
  [[nodiscard]] const std::set<TaskId>& waiting() const { return waiting_; }

  /// The task is closed: nothing is held against it.
  void clear(const TaskId& task);
  /// This identity lives: what it was said to have died of did not kill it. Returns the tasks that
  /// waited as suspects and are suspect no more; they are to be opened again.
  std::vector<TaskId> forgive(const std::string& identity);

 private:
  std::map<TaskId, Charges> charges_;
  std::set<TaskId> waiting_;
};

}  // namespace tessera::server
