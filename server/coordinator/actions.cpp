#include "common/base/log.hpp"
#include "server/coordinator/impl.hpp"
#include "server/film/film_tile_bytes.hpp"

/// What the scheduler wants done, done.
namespace tessera::server {

namespace {

Instant now() { return std::chrono::steady_clock::now(); }

}  // namespace

void CoordinatorImpl::perform(const Actions& actions) {
  for (const Action& action : actions)
    std::visit([this](const auto& one) { perform_one(one); }, action);
  wake_in_time();
}

void CoordinatorImpl::perform_one(const GrantLease& grant) {
  Job* job = find(grant.job);
  const auto found = workers_.find(grant.worker);
  if (!job || found == workers_.end()) return;
  if (!job->first_lease && !job->ending) {
    job->first_lease = now();
    job->record.started = unix_millis_now();
    if (job->record.state == "queued") job->record.state = "rendering";
    keep(*job);
    tell_job(grant.job);
  }
  ++counters_.leases_granted;
  wire::Assign assign;
  assign.lease = grant.lease;
  assign.job = grant.job;
  assign.plan = job->plan->digest;
  assign.task = grant.task;
  if (found->second.told.insert(grant.job).second) assign.spec = for_workers(job->plan->spec);
  found->second.link->send(std::move(assign));
}

void CoordinatorImpl::perform_one(const RevokeLeases& revoke) {
  counters_.leases_revoked += revoke.leases.size();
  if (revoke.expired) counters_.leases_expired += revoke.leases.size();
  constexpr std::size_t most = 4096;  // wire::leases_per_message
  for (std::size_t first = 0; first < revoke.leases.size(); first += most) {
    const auto from = revoke.leases.begin() + static_cast<std::ptrdiff_t>(first);
    const auto to = revoke.leases.begin() +
                    static_cast<std::ptrdiff_t>(std::min(first + most, revoke.leases.size()));
    send(revoke.worker, wire::Revoke{{from, to}, revoke.reason});
  }
}

void CoordinatorImpl::perform_one(const DropWorker& drop) {
  const auto found = workers_.find(drop.worker);
  if (found == workers_.end()) return;
  log::warn("worker {} ({}) is dropped: {}", drop.worker, found->second.info.name, drop.reason);
  found->second.link->close(drop.reason);
}

void CoordinatorImpl::perform_one(const JobFailed& failed) {
  Job* job = find(failed.job);
  if (!job || job->ending || job->ended) return;
  job->ending = true;
  if (job->broken) return;
  log::error("job {} has failed: {}", failed.job, failed.reason);
  crew_.start("a job's failure", abandon_job(failed.job, "failed", failed.reason));
}

void CoordinatorImpl::perform_one(const JobShortened& shortened) {
  Job* job = find(shortened.job);
  // A cancel that is being kept may yet be refused by the disk, and then this stands.
  if (!job || job->ended) return;
  log::info("job {}: its time is up, or its noise is low enough; it ends with {} of {} samples",
            shortened.job, shortened.samples, job->record.spec.render.samples);
  job->record.shortened_from = job->record.spec.render.samples;
  job->record.spec.render.samples = shortened.samples;
  job->shortened = true;
  job->spec_changed();
}

void CoordinatorImpl::perform_one(const FrameShortened& shortened) {
  Job* job = find(shortened.job);
  if (!job || job->ended) return;
  const auto& [id, frame, samples] = shortened;
  const auto [known, fresh] = job->record.shortened_frames.emplace(frame, samples);
  if (!fresh && known->second == samples) return;  // read back at the start
  if (!fresh)
    log::error("job {} frame {}: it was kept to have ended with {} samples", id, frame,
               known->second);
  known->second = samples;
  log::info("job {} frame {}: its noise is low enough; it ends with {} of {} samples", id, frame,
            samples, job->record.spec.render.samples);
  job->shortened_unsaved.insert(frame);
}

void CoordinatorImpl::perform_one(const MeasureNoise& asked) {
  const Job* job = find(asked.job);
  if (!job) return;
  const std::int64_t pixels = job->plan->grid.window().pixels();
  NoiseLook look;
  look.job = asked.job;
  look.frame = asked.frame;
  look.bytes = film_bytes(pixels, *image::layout_of(job->plan->spec.render.aovs)) +
               noise_bytes * static_cast<std::uint64_t>(pixels);
  look.wanted = [this, asked, plan = job->plan->digest] {
    const Job* still = find(asked.job);
    return still && still->awaits_noise(plan);
  };
  look.tell = [this, asked](double noise) {
    perform(scheduler_.noise_measured(asked.job, asked.frame, asked.passes, noise, now()));
  };
  crew_.start("a look at a frame's noise", noise_looks_.look(std::move(look)));
}

void CoordinatorImpl::perform_one(const JobFinished& finished) {
  Job* job = find(finished.job);
  if (!job || job->ending || job->ended) return;
  job->ending = true;
  if (!job->last_fold) job->last_fold = now();
  crew_.start("a job's end", finish_job(finished.job));
}

void CoordinatorImpl::perform_one(const FrameFinished& finished) {
  const Job* job = find(finished.job);
  if (job && !job->files.contains(finished.frame))
    crew_.start("a frame's file", finish_frame(finished.job, finished.frame));
}

void CoordinatorImpl::tile_folded(JobId id, std::int32_t frame, std::uint32_t tile,
                                  std::uint32_t passes) {
  Job* job = find(id);
  if (!job) return;
  job->last_fold = now();
  frame_news_.changed(id, frame, now());
  tell_job(id);
  perform(scheduler_.tile_folded(id, frame, tile, passes, now()));
  compact_in_time(id, frame);
}

}  // namespace tessera::server
