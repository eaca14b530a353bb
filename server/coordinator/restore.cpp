#include <algorithm>
#include <map>
#include <set>

#include "common/base/log.hpp"
#include "server/coordinator/frame_file.hpp"
#include "server/coordinator/impl.hpp"

/// After a start, and for a job that is extended: what the store holds is given to scheduler and
/// films.
namespace tessera::server {

namespace {

Instant now() { return std::chrono::steady_clock::now(); }

}  // namespace

void CoordinatorImpl::restore() {
  const std::vector<JobRecord> records = store_->list_jobs();
  settle_job_folders(records);
  for (Quarantine& one : store_->quarantines()) {
    perform(scheduler_.quarantine(one.name, one.reason, now()));
    quarantines_.restore(std::move(one));
  }
  for (const JobRecord& record : records) restore_job(record);
  look_at_ended();
  for (const auto& [id, count] : store_->failure_counts())
    if (Job* job = find(id)) job->failures = count;
  if (!jobs_.empty()) log::info("epoch {}: {} jobs read back", epoch(), jobs_.size());
}

void CoordinatorImpl::look_at_ended() {
  const std::vector<JobId> with_results = store_->jobs_with_results();
  const std::vector<JobId> with_checkpoints = store_->jobs_with_checkpoints();
  std::set<JobId> with_something(with_results.begin(), with_results.end());
  with_something.insert(with_checkpoints.begin(), with_checkpoints.end());
  for (const JobId id : with_something) {
    Job* job = find(id);
    if (job && !job->ended) continue;
    try {
      if (!job) {
        store_->end_job(id);
      } else if (job->record.state != "done") {
        job->owed.emplace();
      } else if (!std::binary_search(with_results.begin(), with_results.end(), id)) {
        continue;  // it goes on from its checkpoints if samples are added
      } else if (!store_->damage().contains(id)) {
        // Where a file is lacking its pictures stand, and the rest may be whole again one day.
        settle_what_is_left(*job, read_job(*store_, id));
        crew_.start("a done job's results", forget_settled(id));
      }
    } catch (const std::exception& error) {
      log::warn("job {}: its results could not be removed from the journal: {}", id, error.what());
    }
  }
}

void CoordinatorImpl::restore_job(const JobRecord& record) {
  Job& job = jobs_.try_emplace(record.id, record, now(), unix_millis_now()).first->second;
  job.files = frames_on_disk(settings_.data, record.id);
  if (!record.idempotency_key.empty())
    requests_[record.idempotency_key] = {record.id, record.idempotency_fingerprint};
  if (job.ended) return;
  if (settings_.durable) settle_frames(settings_.data, record.id);
  // Files of the plan before are pictures no longer.
  if (!record.extended_from.empty())
    std::erase_if(job.files, [&](std::int32_t frame) {
      return samples_of_file(frame_path(settings_.data, record.id, frame)) != job.samples_of(frame);
    });
  perform(scheduler_.add_job(record.id, job.plan, now(), job.earlier_plans));
  // Until all that is durable is known nothing is decided by a part of it.
  perform(scheduler_.pause_job(record.id, now()));
  if (job.first_lease) scheduler_.restore_started(record.id, *job.first_lease);
  const JobContent content = read_job(*store_, record.id);
  take_in(job, content);
  if (const auto damage = store_->damage().find(record.id); damage != store_->damage().end())
    return fail_job(record.id, damage->second);
  settle_what_is_left(job, content);
  if (record.state != "paused") perform(scheduler_.resume_job(record.id, now()));
}

std::map<std::int32_t, FrameFilm*> CoordinatorImpl::restore_films(const Job& job,
                                                                  const JobContent& content,
                                                                  bool also_written) {
  const JobId id = job.record.id;
  std::map<std::int32_t, FrameFilm*> films;
  const auto wanted = [&](std::int32_t frame) {
    return also_written || !job.files.contains(frame);
  };
  const auto film_of = [&](std::int32_t frame) -> FrameFilm& {
    FrameFilm*& film = films[frame];
    if (!film) film = &films_.open(id, job.plan, frame, job.version_base);
    return *film;
  };
  for (const Checkpoint& checkpoint : content.checkpoints) {
    if (!wanted(checkpoint.frame)) continue;
    for (const CheckpointTile& tile : checkpoint.tiles)
      film_of(checkpoint.frame)
          .restore_checkpoint(tile.tile, tile.passes,
                              {checkpoint.number, tile.offset, tile.length});
  }
  for (const auto& [task, place] : content.results)
    if (wanted(task.frame)) film_of(task.frame).restore(task.tile, task.pass, place);
  for (const auto& [frame, film] : films) film->restored();
  return films;
}

void CoordinatorImpl::take_in(Job& job, const JobContent& content) {
  const JobId id = job.record.id;
  std::erase_if(job.record.shortened_frames, [&](const auto& end) {
    const auto& [frame, samples] = end;
    if (scheduler_.restore_shortened(id, frame, samples)) return false;
    log::error(
        "job {} frame {}: it is kept to have ended by its noise with {} samples, where it "
        "cannot: it goes on",
        id, frame, samples);
    job.files.erase(frame);
    // A job that has ended is shown as the store says, so this must not stand there till then.
    job.shortened_unsaved.insert(frame);
    crew_.start("a frame's end", keep_end_of(id, frame));
    return true;
  });
  // Before it is told of passes: what it wants done then is begun at once.
  const std::map<std::int32_t, FrameFilm*> films = restore_films(job, content, false);
  for (const Tally& tally : content.tallies)
    job.count(tally.worker_name, tally.samples, tally.rays, tally.rejected, tally.cpu_seconds,
              tally.worker_build);
  for (const Checkpoint& checkpoint : content.checkpoints)
    if (!job.files.contains(checkpoint.frame))
      for (const CheckpointTile& tile : checkpoint.tiles)
        perform(scheduler_.tile_folded(id, checkpoint.frame, tile.tile, tile.passes, now()));
  for (const auto& [task, place] : content.results) scheduler_.restore_closed(id, task);
  if (job.build) scheduler_.restore_build(id, *job.build);
  // What is durable in order counts as folded from the start, so that work is handed out at once;
  // the sums are read back when they are needed.
  for (const auto& [frame, film] : films)
    for (std::uint32_t tile = 0; tile < film->tile_count(); ++tile)
      if (film->passes(tile) > 0)
        perform(scheduler_.tile_folded(id, frame, tile, film->passes(tile), now()));
  for (const std::int32_t frame : job.files)
    for (std::uint32_t tile = 0; tile < job.plan->grid.count(); ++tile)
      perform(scheduler_.tile_folded(id, frame, tile, job.passes_of(frame), now()));
}

}  // namespace tessera::server
