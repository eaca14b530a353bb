#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

#include "worker/agent/agent_state.hpp"

/// Which scenes are built, kept and let go of.
namespace tessera::agent {

bool AgentState::wanted(const JobKey& key) const {
  const auto found = jobs_.find(key);
  return found != jobs_.end() && found->second.queued > 0;
}

std::optional<PrepareOrder> AgentState::take_prepare() {
  const auto lacks_scene = [](const auto& entry) {
    return entry.second.queued > 0 && !entry.second.scene;
  };
  if (preparing_ || draining_ || std::none_of(jobs_.begin(), jobs_.end(), lacks_scene))
    return std::nullopt;
  for (const auto& [number, held] : queued_) {
    const Job& job = jobs_.at(held.job);
    if (job.scene) continue;
    make_room_for(*job.plan);
    preparing_ = held.job;
    prepare_fraction_ = 0;
    return PrepareOrder{.job = held.job,
                        .plan = job.plan,
                        .blob_url = welcome_.blob_url,
                        .blob_token = welcome_.blob_token};
  }
  return std::nullopt;
}

bool AgentState::prepare_unwanted() const {
  // While there is no connection nobody can want it, but its leases may well come back.
  return preparing_ && (draining_ || (connected_ && !wanted(*preparing_)));
}

void AgentState::prepared(std::shared_ptr<const PreparedScene> scene) {
  const auto found = preparing_ ? jobs_.find(*preparing_) : jobs_.end();
  preparing_.reset();
  if (found == jobs_.end()) return let_go_.push_back(std::move(scene));
  auto& [key, job] = *found;
  for (Job* const lesser : jobs_with_less_than(*job.plan))
    if (scene->serves(lesser->plan->spec.render))
      let_go_.push_back(std::exchange(lesser->scene, scene));
  job.scene = std::move(scene);
  job.used = ++clock_;
  job.announced = false;
  if (wanted(key)) say_ready(key, job);
  trim_scenes();
}

void AgentState::prepare_stopped() { preparing_.reset(); }

void AgentState::prepare_failed(const std::string& code, const std::string& reason) {
  if (!preparing_) return;
  const JobKey key = *preparing_;
  preparing_.reset();
  if (wanted(key)) fail_job(key, code, reason);
}

void AgentState::fail_job(const JobKey& key, const std::string& code, const std::string& reason) {
  say(wire::Failed{.job = key.first, .lease = std::nullopt, .code = code, .reason = reason});
  jobs_.at(key).announced = false;
  for (auto at = queued_.begin(); at != queued_.end();) {
    const auto next = std::next(at);
    if (at->second.job == key) dequeue(at);
    at = next;
  }
}

std::vector<AgentState::Job*> AgentState::jobs_with_less_than(const JobPlan& plan) {
  std::vector<Job*> out;
  for (auto& [key, job] : jobs_)
    if (job.scene && job.plan->spec.bundle == plan.spec.bundle &&
        !job.scene->serves(plan.spec.render))
      out.push_back(&job);
  return out;
}

void AgentState::make_room_for(const JobPlan& plan) {
  for (Job* const lesser : jobs_with_less_than(plan))
    if (lesser->idle()) let_go(*lesser);
}

void AgentState::trim_scenes() {
  while (true) {
    std::set<const void*> built;  // jobs of one bundle may share a scene
    Job* oldest = nullptr;
    for (auto& [key, job] : jobs_) {
      if (!job.scene) continue;
      built.insert(job.scene.get());
      if (job.idle() && (oldest == nullptr || job.used < oldest->used)) oldest = &job;
    }
    if (built.size() <= settings_.scenes_kept || oldest == nullptr) return;
    let_go(*oldest);
  }
}

void AgentState::let_go(Job& job) {
  let_go_.push_back(std::move(job.scene));
  job.announced = false;
}

std::vector<std::shared_ptr<const PreparedScene>> AgentState::take_let_go() {
  return std::exchange(let_go_, {});
}

}  // namespace tessera::agent
