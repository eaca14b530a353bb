#include "server/schedule/blame.hpp"

namespace tessera::server {

const Charges* BlameTable::find(const TaskId& task) const {
  const auto found = charges_.find(task);
  return found == charges_.end() ? nullptr : &found->second;
}

void BlameTable::clear(const TaskId& task) {
  charges_.erase(task);
  waiting_.erase(task);
}

std::vector<TaskId> BlameTable::forgive(const std::string& identity) {
  std::vector<TaskId> cleared;
  for (auto entry = charges_.begin(); entry != charges_.end();) {
    auto& [task, charges] = *entry;
    charges.lost.erase(identity);
    charges.lost_alone.erase(identity);
    if (charges.lost.empty() && charges.lost_alone.empty()) charges.lost_names.clear();
    if (!charges.none()) {
      ++entry;
      continue;
    }
    if (waiting_.erase(task) != 0) cleared.push_back(task);
    entry = charges_.erase(entry);
  }
  return cleared;
}

}  // namespace tessera::server
