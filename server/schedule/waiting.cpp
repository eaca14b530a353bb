// Why a job does not get on.
#include "server/schedule/state.hpp"

namespace tessera::server {

std::string Scheduler::State::waiting_for(const JobEntry& job) const {
  if (job.state != JobEntry::State::open || !job.out.empty() || !job.journaling.empty() ||
      job.tasks.closed() == job.tasks.tasks()) {
    return {};
  }
  if (workers.empty()) return "no worker is connected";
  std::size_t of_its_build = 0, usable = 0, stalled = 0;
  bool all_unable = true, all_without_files = true;
  for (const auto& [id, worker] : workers) {
    if (!job.takes(worker.info.build_id)) continue;
    ++of_its_build;
    if (worker.stalled()) ++stalled;
    if (worker.draining || worker.barred || worker.stalled()) continue;
    ++usable;
    // Where nobody else is left to ask, one that could not is asked again after its rest.
    const bool unable = job.unable.contains(worker.info.identity) ||
                        (worker.rests && job.unable_names.contains(worker.info.name));
    const bool without_files = job.without_files.contains(worker.info.identity);
    if (!unable && !without_files) all_unable = false;
    if (!without_files) all_without_files = false;
  }
  if (of_its_build == 0) {
    const std::string build = job.build->hex().substr(0, 12);
    if (workers.size() == 1)
      return fmt::format("its build is {}; the 1 connected worker is of another build", build);
    return fmt::format("its build is {}; the {} connected workers are of other builds", build,
                       workers.size());
  }
  if (usable == 0) {
    return fmt::format(
        "every worker{} is {}", of_its_build < workers.size() ? " of its build" : "",
        stalled > 0 ? "draining, quarantined or stalled" : "draining or quarantined");
  }
  if (!all_unable) return {};
  if (all_without_files)
    return fmt::format("no connected worker{} can read its files: {}",
                       of_its_build < workers.size() ? " of its build" : "",
                       job.without_files_reason);
  return fmt::format("preparation failed on every connected worker{}: {}",
                     of_its_build < workers.size() ? " of its build" : "", job.unable_reason);
}

}  // namespace tessera::server
