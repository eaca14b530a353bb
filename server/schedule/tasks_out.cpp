#include "server/schedule/tasks_out.hpp"

namespace tessera::server {

const std::vector<Holder>& TasksOut::holders(const TaskId& task) const {
  static const std::vector<Holder> none;
  const auto found = out_.find(task);
  return found == out_.end() ? none : found->second.holders;
}

void TasksOut::add(const TaskId& task, const Holder& holder) {
  out_[task].holders.push_back(holder);
  expect(task, unknown);
}

void TasksOut::remove(const TaskId& task, const LeaseId& lease) {
  const auto found = out_.find(task);
  if (found == out_.end()) return;
  std::erase_if(found->second.holders, [&](const Holder& one) { return one.lease == lease; });
  if (!found->second.holders.empty()) return expect(task, unknown);
  by_end_.erase({found->second.end, task});
  out_.erase(found);
}

void TasksOut::clear() {
  out_.clear();
  by_end_.clear();
}

void TasksOut::expect(const TaskId& task, Instant end) {
  const auto found = out_.find(task);
  if (found == out_.end()) return;
  by_end_.erase({found->second.end, task});
  found->second.end = end;
  by_end_.emplace(end, task);
}

void TasksOut::unlist(const TaskId& task) {
  const auto found = out_.find(task);
  if (found != out_.end()) by_end_.erase({found->second.end, task});
}

}  // namespace tessera::server
