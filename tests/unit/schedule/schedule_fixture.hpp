#pragma once
#include <gtest/gtest.h>

#include <algorithm>

#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "server/schedule/scheduler.hpp"

namespace tessera::server {

/// A scheduler under a clock that only the test moves, and what it has said.
class ScheduleTest : public ::testing::Test {
 protected:
  explicit ScheduleTest(SchedulerSettings settings = {})
      : scheduler_(settings), settings_(settings) {}

  /// A job of tiles × 1 tiles of 16×16 pixels.
  static JobSpec spec(int tiles, std::int64_t samples, FrameRange frames = {1, 1, 1}) {
    JobSpec spec;
    spec.name = "job";
    spec.bundle = digest_of("bundle");
    spec.render.width = 16 * tiles;
    spec.render.height = 16;
    spec.render.samples = samples;
    spec.tile = 16;
    spec.frames = frames;
    return spec;
  }
  void add(JobId id, const JobSpec& spec) {
    plans_[id] = std::make_shared<const JobPlan>(spec);
    take(scheduler_.add_job(id, plans_[id], now_));
  }
  WorkerId join(const std::string& identity, const std::string& build = "build", int threads = 1) {
    const WorkerInfo info{identity, identity, threads, digest_of(build)};
    auto joined = scheduler_.worker_joined(info, now_);
    identities_[joined.worker] = identity;
    take(joined.actions);
    return joined.worker;
  }

  /// Keeps what the scheduler has said; leases that are granted are held until they end.
  void take(const Actions& actions) {
    for (const Action& action : actions) {
      if (const auto* grant = std::get_if<GrantLease>(&action))
        held_[grant->worker].push_back(*grant);
      if (const auto* revoke = std::get_if<RevokeLeases>(&action)) {
        for (const LeaseId& lease : revoke->leases) {
          std::erase_if(held_[revoke->worker],
                        [&](const GrantLease& grant) { return grant.lease == lease; });
          revoked_.insert(lease);
        }
      }
      if (const auto* drop = std::get_if<DropWorker>(&action)) {
        dropped_.push_back(drop->worker);
        held_.erase(drop->worker);
      }
      if (const auto* failed = std::get_if<JobFailed>(&action))
        failed_[failed->job] = failed->reason;
      if (const auto* shortened = std::get_if<JobShortened>(&action))
        shortened_[shortened->job] = shortened->samples;
      if (const auto* shortened = std::get_if<FrameShortened>(&action))
        frames_shortened_[{shortened->job, shortened->frame}] = shortened->samples;
      if (const auto* asked = std::get_if<MeasureNoise>(&action)) asked_.push_back(*asked);
      if (const auto* finished = std::get_if<JobFinished>(&action))
        finished_.push_back(finished->job);
      if (const auto* barred = std::get_if<WorkerQuarantined>(&action))
        quarantined_[barred->worker] = barred->reason;
      if (const auto* failure = std::get_if<AttemptFailed>(&action)) failures_.push_back(*failure);
      if (const auto* frame = std::get_if<FrameFinished>(&action)) frames_.push_back(frame->frame);
    }
  }
  void pass(double seconds) {
    now_ += std::chrono::duration_cast<Duration>(std::chrono::duration<double>(seconds));
    take(scheduler_.tick(now_));
  }
  void leave(WorkerId worker, bool clean) {
    held_.erase(worker);
    take(scheduler_.worker_left(worker, clean, now_));
  }
  void ready(WorkerId worker, JobId job = 1) { take(scheduler_.worker_ready(worker, job, now_)); }

  Verdict arrive(WorkerId worker, const GrantLease& grant) {
    return scheduler_.result_arrived(worker, grant.lease, grant.job, plans_[grant.job]->digest,
                                     grant.task, now_);
  }
  void durable(WorkerId worker, const GrantLease& grant) {
    const std::int64_t samples = plans_[grant.job]->grid.tile(grant.task.tile).pixels() *
                                 plans_[grant.job]->passes.pass(grant.task.pass).count;
    take(scheduler_.result_durable(worker, grant.lease, grant.job, grant.task, samples, 0.1, now_));
  }
  void fold(JobId job, const TaskId& task) {
    take(scheduler_.tile_folded(job, task.frame, task.tile, task.pass + 1, now_));
  }
  /// The oldest lease of the worker comes in, is kept, and (unless told otherwise) folded.
  GrantLease finish_one(WorkerId worker, bool folded = true) {
    const GrantLease grant = held_[worker].at(0);
    held_[worker].erase(held_[worker].begin());
    EXPECT_EQ(arrive(worker, grant), Verdict::take);
    durable(worker, grant);
    if (folded) fold(grant.job, grant.task);
    return grant;
  }

  Scheduler scheduler_;
  SchedulerSettings settings_;
  Instant now_{std::chrono::seconds(1000)};
  std::map<JobId, std::shared_ptr<const JobPlan>> plans_;
  std::map<WorkerId, std::string> identities_;
  std::map<WorkerId, std::vector<GrantLease>> held_;
  std::set<LeaseId> revoked_;
  std::vector<WorkerId> dropped_;
  std::map<JobId, std::string> failed_;
  std::vector<JobId> finished_;
  std::map<JobId, std::int64_t> shortened_;
  std::map<std::pair<JobId, std::int32_t>, std::int64_t> frames_shortened_;
  std::vector<std::int32_t> frames_;
  std::vector<MeasureNoise> asked_;
  std::vector<AttemptFailed> failures_;
  std::map<WorkerId, std::string> quarantined_;
};

}  // namespace tessera::server
