// How jobs come, and how they and their frames end.
#include "server/coordinator/frame_file.hpp"
#include "server/store/whole_file.hpp"
#include "tests/sim/coordinator.hpp"
#include "tests/sim/synthetic.hpp"

namespace tessera::sim {

// ---- jobs ----

void Coordinator::submit(const JobSpec& spec) {
  server::JobRecord record;
  record.spec = spec;
  record.priority = spec.priority;
  JobId id = 0;
  if (up()) done("a job's taking", [&] { id = store_->put_job(record); });
  if (id == 0 || world_.drive.dead()) {
    // The client was not answered, and asks again; the job may be there twice then.
    world_.events.after(1, [this, spec] { submit(spec); });
    return;
  }
  --world_.unanswered;
  Disk::Job& job = world_.disk.jobs[id];
  job.plan = job.asked = std::make_shared<const JobPlan>(spec);
  plans_[id] = job.plan->digest;
  focus_[id] = spec.focus;
  apply(scheduler_->add_job(id, job.plan, world_.events.now()));
}

server::JobRecord Coordinator::record_of(JobId id, const std::string& state) const {
  server::JobRecord record;
  record.id = id;
  record.spec = world_.disk.jobs.at(id).plan->spec;
  record.priority = record.spec.priority;
  record.state = state;
  if (const auto begun = started_.find(id); begun != started_.end())
    record.started = static_cast<UnixMillis>(begun->second * 1000) + 1;
  if (const auto cut = shortened_.find(id); cut != shortened_.end())
    record.spec.render.samples = cut->second;
  return record;
}

void Coordinator::keep_started(JobId id) {
  later(world_.random.between(0, 0.05), [this, id] {
    const Disk::Job& job = world_.disk.jobs.at(id);
    // What else is known of it by now is kept with it, or not.
    if (!job.ended.empty() || shortened_.contains(id)) return;
    bool kept = false;
    done("a job's beginning", [&] { store_->update_job(record_of(id, "rendering")), kept = true; });
    if (!kept && !world_.drive.dead()) keep_started(id);
  });
}

bool Coordinator::keep_shortened(JobId id) {
  const auto cut = shortened_.find(id);
  Disk::Job& job = world_.disk.jobs.at(id);
  if (cut == shortened_.end() || job.plan->spec.render.samples == cut->second) return true;
  const server::JobRecord record = record_of(id, "rendering");
  job.doubtful_samples.insert(cut->second);
  bool kept = false;
  done("that a job's time is up", [&] { store_->update_job(record), kept = true; });
  if (kept) {
    job.plan = std::make_shared<const JobPlan>(record.spec);
    ++world_.shortened;
  }
  return kept;
}

bool Coordinator::keep_shortened(JobId id, std::int32_t frame) {
  Disk::Job& job = world_.disk.jobs.at(id);
  const auto cut = job.said.find(frame);
  if (cut == job.said.end() || job.shortened.contains(frame)) return true;
  done("that a frame's noise is low enough", [&] {
    store_->shorten_frame(id, frame, cut->second);
    job.shortened.insert(*cut);
    ++world_.frames_shortened;
  });
  return job.shortened.contains(frame);
}

void Coordinator::cancel(JobId job) {
  if (!up() || !world_.disk.jobs.contains(job) || !world_.disk.jobs[job].ended.empty()) return;
  if (finishing_.contains(job)) return;
  end(job, "cancelled");
  if (up() && world_.disk.jobs[job].ended == "cancelled")
    apply(scheduler_->cancel_job(job, world_.events.now()));
}

void Coordinator::end(JobId id, const std::string& state) {
  Disk::Job& job = world_.disk.jobs.at(id);
  const server::JobRecord record = record_of(id, state);
  if (record.spec != job.plan->spec) job.doubtful_samples.insert(record.spec.render.samples);
  bool kept = false;
  done("a job's end", [&] { store_->update_job(record), kept = true; });
  if (!kept) {
    job.doubtful_ends.insert(state);
    return;
  }
  job.ended = state;
  job.plan = std::make_shared<const JobPlan>(record.spec);
  if (world_.drive.dead()) return;
  // What fails here the next start does again.
  done("a job's results are let go", [&] { store_->end_job(id); });
}

// ---- ends ----

void Coordinator::write_frame(JobId id, std::int32_t frame) {
  Disk::Job& job = world_.disk.jobs.at(id);
  if (!job.ended.empty() || job.files.contains(frame)) return;
  server::FrameFilm& film = film_of(id, frame);
  const auto again = [this, id, frame](double delay) {
    later(delay, [this, id, frame] { write_frame(id, frame); });
  };
  // Before the file: a start that finds it must not take it for one of all the samples.
  if (!keep_shortened(id) || !keep_shortened(id, frame)) {
    if (!world_.drive.dead()) again(0.5);
    return;
  }
  if (world_.drive.dead()) return;
  if (!film.loaded()) {
    demand(id, frame);
    again(0.05);
    return;
  }
  const std::vector<std::byte> bytes = bytes_of(film.snapshot());
  bool written = false;
  done("a picture's file", [&] {
    server::write_whole(world_.drive, server::frame_path(data_folder, id, frame), true,
                        [&](server::DiskFile& file) { file.write_at(bytes, 0); });
    written = true;
  });
  if (world_.drive.dead()) return;
  if (!written) {
    again(0.5);
    return;
  }
  job.files.insert(frame);
  films_.erase({id, frame});
}

void Coordinator::finish(JobId id) {
  Disk::Job& job = world_.disk.jobs.at(id);
  if (!job.ended.empty()) return;
  if (job.files.size() >= job.plan->spec.frames.count()) end(id, "done");
  if (!job.ended.empty() || world_.drive.dead()) return;
  later(0.2, [this, id] { finish(id); });
}

}  // namespace tessera::sim
