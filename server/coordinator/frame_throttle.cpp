#include "server/coordinator/frame_throttle.hpp"

#include <algorithm>

namespace tessera::server {

void FrameThrottle::changed(JobId job, std::int32_t frame, Instant now) {
  Job& entry = jobs_.try_emplace(job, Job{now, {}}).first->second;
  if (std::find(entry.waiting.begin(), entry.waiting.end(), frame) == entry.waiting.end())
    entry.waiting.push_back(frame);
}

std::vector<FrameThrottle::Frame> FrameThrottle::due(Instant now) {
  std::vector<Frame> told;
  for (auto& [job, entry] : jobs_) {
    if (entry.waiting.empty() || entry.free > now) continue;
    told.emplace_back(job, entry.waiting.front());
    entry.waiting.pop_front();
    entry.free = now + spacing_;
  }
  return told;
}

std::vector<FrameThrottle::Frame> FrameThrottle::forget(JobId job) {
  std::vector<Frame> told;
  const auto found = jobs_.find(job);
  if (found == jobs_.end()) return told;
  for (const std::int32_t frame : found->second.waiting) told.emplace_back(job, frame);
  jobs_.erase(found);
  return told;
}

std::optional<Instant> FrameThrottle::next_deadline() const {
  std::optional<Instant> earliest;
  for (const auto& [job, entry] : jobs_)
    if (!entry.waiting.empty() && (!earliest || entry.free < *earliest)) earliest = entry.free;
  return earliest;
}

}  // namespace tessera::server
