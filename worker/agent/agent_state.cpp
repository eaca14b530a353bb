#include "worker/agent/agent_state.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace tessera::agent {

AgentState::AgentState(StateSettings settings) : settings_(settings), jitter_(settings.jitter) {}

void AgentState::say(wire::Message message, TileBytes body) {
  if (connected_) outgoing_.push_back({.message = std::move(message), .body = std::move(body)});
}

// ---- the connection ----
void AgentState::connected(const wire::Welcome& welcome, Instant now) {
  connected_ = true;
  attempts_ = 0;
  welcome_ = welcome;
  next_beat_ = now;
  for (const auto& [number, owed] : outbox_) say(owed.result, owed.bytes);
  if (draining_) say(wire::Drain{.reason = "this worker is leaving"});
}

Duration AgentState::disconnected() {
  connected_ = false;
  outgoing_.clear();
  drop_queued();
  for (auto& [lease, held] : running_) held.of_this_connection = false;
  for (auto& [key, job] : jobs_) job.announced = false;
  std::erase_if(jobs_, [this](const auto& entry) {
    return !entry.second.scene && entry.second.running == 0 && entry.first != preparing_;
  });
  const double doubled = std::ldexp(seconds(settings_.backoff_first), std::min(attempts_++, 30));
  const double most = std::min(doubled, seconds(settings_.backoff_most));
  jitter_ = jitter_ * 6364136223846793005ULL + 1442695040888963407ULL;
  const double chance = static_cast<double>(jitter_ >> 11U) * 0x1p-53;
  return std::chrono::duration_cast<Duration>(
      std::chrono::duration<double>(most * (1 - 0.5 * chance)));
}

std::optional<int> AgentState::refused(const wire::Refused& refused) {
  if (refused.code == "full") return std::nullopt;
  if (refused.code == "version" || refused.code == "protocol") return 1;
  return 4;
}

void AgentState::said(const wire::Message& message, Instant) {
  if (const auto* assign = std::get_if<wire::Assign>(&message)) {
    assigned(*assign);
  } else if (const auto* revoke = std::get_if<wire::Revoke>(&message)) {
    revoked(*revoke);
  } else if (const auto* accepted = std::get_if<wire::Accepted>(&message)) {
    settled(accepted->lease, true);
  } else if (const auto* stale = std::get_if<wire::Stale>(&message)) {
    settled(stale->lease, true);
  } else if (const auto* rejected = std::get_if<wire::Rejected>(&message)) {
    settled(rejected->lease, false);
  } else if (const auto* drained = std::get_if<wire::Drain>(&message)) {
    drain(drained->reason);
  }
}

// ---- time ----
void AgentState::tick(Instant now) {
  if (!connected_ || now < next_beat_) return;
  // Three beats in the time of two, so that one that is a little late is not missed.
  next_beat_ = now + std::chrono::milliseconds(welcome_.heartbeat_ms) * 2 / 3;
  wire::Progress progress;
  for (const auto& [lease, held] : running_)
    // Revoked or not: its thread is not free before it ends.
    if (held.of_this_connection)
      progress.running.push_back({.lease = lease, .fraction = held.fraction});
  progress.cache = cache_;
  say(std::move(progress));
  // Wanted or not: the thread that builds it is not free before it ends.
  if (preparing_ && !wanted(*preparing_))
    say(wire::Preparing{.job = preparing_->first, .fraction = prepare_fraction_});
  for (const auto& [key, job] : jobs_)
    if (job.queued > 0 && !job.scene)
      say(wire::Preparing{.job = key.first, .fraction = key == preparing_ ? prepare_fraction_ : 0});
}

// ---- leases ----
void AgentState::enqueue(const Held& held) {
  queued_at_[held.lease] = ++clock_;
  queued_.emplace(clock_, held);
  ++jobs_.at(held.job).queued;
}

AgentState::Held AgentState::dequeue(std::map<std::uint64_t, Held>::iterator at) {
  Held held = at->second;
  queued_at_.erase(held.lease);
  queued_.erase(at);
  --jobs_.at(held.job).queued;
  return held;
}

void AgentState::drop_queued() {
  queued_.clear();
  queued_at_.clear();
  parked_.clear();
  for (auto& [key, job] : jobs_) job.queued = 0;
}

void AgentState::assigned(const wire::Assign& assign) {
  if (draining_) return;  // the bye gives it back
  const JobKey key(assign.job, assign.plan);
  auto found = jobs_.find(key);
  const auto refuse = [&](const std::string& reason) {
    say(wire::Failed{.job = assign.job, .lease = assign.lease, .code = "scene", .reason = reason});
  };
  if (found == jobs_.end() || !found->second.plan) {
    if (!assign.spec) return refuse("the job's description did not come with its first lease");
    auto plan = std::make_shared<const JobPlan>(*assign.spec);
    if (plan->digest != assign.plan)
      return refuse(
          "this worker cuts the job's frames into other tasks than the coordinator: another "
          "release?");
    found = jobs_.emplace(key, Job{.plan = std::move(plan)}).first;
  }
  Job& job = found->second;
  if (!job.plan->contains(assign.task))
    return refuse(fmt::format("the job has no {}", text_of(assign.task)));
  job.used = ++clock_;
  const Held held{.lease = assign.lease, .job = key, .task = assign.task};
  const TaskKey task(key, assign.task);
  if (under_way_.contains(task)) {
    parked_[task].push_back(held);
  } else {
    enqueue(held);
  }
  if (job.scene) {
    say_ready(key, job);
  } else if (!job.announced) {
    // Said once at the beginning, then with every heartbeat.
    job.announced = true;
    say(wire::Preparing{.job = assign.job, .fraction = 0});
  }
}

void AgentState::say_ready(const JobKey& key, Job& job) {
  if (job.announced) return;
  job.announced = true;
  say(wire::Ready{.job = key.first});
}

void AgentState::revoked(const wire::Revoke& revoke) {
  for (const LeaseId& lease : revoke.leases) {
    if (const auto at = queued_at_.find(lease); at != queued_at_.end()) {
      dequeue(queued_.find(at->second));
    } else if (const auto running = running_.find(lease); running != running_.end()) {
      running->second.revoked = true;
      stops_.push_back(lease);
    } else if (!parked_.empty()) {
      for (auto& [task, leases] : parked_)
        std::erase_if(leases, [&](const Held& held) { return held.lease == lease; });
      std::erase_if(parked_, [](const auto& entry) { return entry.second.empty(); });
    }
  }
}

void AgentState::settled(const LeaseId& lease, bool task_closed) {
  const auto at = outbox_at_.find(lease);
  if (at == outbox_at_.end()) return;
  const auto owed = outbox_.find(at->second);
  const TaskKey task({owed->second.result.job, owed->second.result.plan}, owed->second.result.task);
  outbox_bytes_ -= owed->second.bytes->size();
  outbox_.erase(owed);
  outbox_at_.erase(at);
  under_way_.erase(task);
  release_parked(task, task_closed);
}

void AgentState::release_parked(const TaskKey& task, bool drop) {
  const auto found = parked_.find(task);
  if (found == parked_.end()) return;
  const std::vector<Held> leases = std::move(found->second);
  parked_.erase(found);
  if (drop || draining_) return;
  for (const Held& held : leases) enqueue(held);
}

std::optional<TaskOrder> AgentState::next_task() {
  if (draining_ || outbox_bytes_ >= settings_.outbox_bytes) return std::nullopt;
  for (auto at = queued_.begin(); at != queued_.end(); ++at) {
    Job& job = jobs_.at(at->second.job);
    const TaskKey task(at->second.job, at->second.task);
    if (!job.scene || under_way_.contains(task)) continue;
    const Held held = dequeue(at);
    ++job.running;
    running_.emplace(held.lease, held);
    under_way_.insert(task);
    job.used = ++clock_;
    return TaskOrder{.lease = held.lease,
                     .job = held.job,
                     .task = held.task,
                     .plan = job.plan,
                     .scene = job.scene};
  }
  return std::nullopt;
}

// ---- tasks ----
void AgentState::task_progress(const LeaseId& lease, double fraction) {
  if (const auto found = running_.find(lease); found != running_.end())
    found->second.fraction = std::clamp(fraction, 0.0, 1.0);
}

void AgentState::end_running(const LeaseId& lease) {
  const auto found = running_.find(lease);
  if (found == running_.end()) return;
  const TaskKey task(found->second.job, found->second.task);
  --jobs_.at(found->second.job).running;
  running_.erase(found);
  under_way_.erase(task);
  release_parked(task, false);
  trim_scenes();
}

void AgentState::task_done(const LeaseId& lease, const RenderedTile& stats, TileBytes bytes) {
  const auto found = running_.find(lease);
  if (found == running_.end()) return;
  const Held held = found->second;
  if (held.revoked) return end_running(lease);
  --jobs_.at(held.job).running;
  running_.erase(found);  // the task stays under way until the result is settled
  const wire::Result result{.lease = lease,
                            .job = held.job.first,
                            .plan = held.job.second,
                            .task = held.task,
                            .samples = stats.samples,
                            .rays = stats.rays,
                            .rejected = stats.rejected,
                            .seconds = stats.seconds,
                            .cpu_seconds = stats.cpu_seconds};
  outbox_bytes_ += bytes->size();
  outbox_at_[lease] = ++clock_;
  say(result, bytes);
  outbox_.emplace(clock_, Owed{.result = result, .bytes = std::move(bytes)});
  trim_scenes();
}

void AgentState::task_failed(const LeaseId& lease, const std::string& code,
                             const std::string& reason) {
  const auto found = running_.find(lease);
  if (found == running_.end()) return;
  if (found->second.of_this_connection && !found->second.revoked)
    say(wire::Failed{
        .job = found->second.job.first, .lease = lease, .code = code, .reason = reason});
  end_running(lease);
}

void AgentState::task_stopped(const LeaseId& lease) { end_running(lease); }

std::vector<Outgoing> AgentState::take_outgoing() { return std::exchange(outgoing_, {}); }
std::vector<LeaseId> AgentState::take_stops() { return std::exchange(stops_, {}); }

// ---- leaving ----
void AgentState::drain(const std::string& reason) {
  if (draining_) return;
  draining_ = true;
  drop_queued();
  say(wire::Drain{.reason = reason});
}

}  // namespace tessera::agent
