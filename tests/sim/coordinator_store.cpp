// What the coordinator keeps, and what it finds again.
#include <fmt/format.h>

#include <algorithm>

#include "common/base/error.hpp"
#include "server/coordinator/frame_file.hpp"
#include "tests/sim/coordinator.hpp"
#include "tests/sim/synthetic.hpp"
#include "tests/sim/worker.hpp"

namespace tessera::sim {

bool Coordinator::done(const char* name, const std::function<void()>& what) {
  const std::uint64_t before = world_.drive.faults.failures();
  bool did = false;
  try {
    what();
    did = world_.drive.commit_point();
  } catch (const Error& error) {
    world_.tell("{} failed: {}", name, error.what());
    require(world_.drive.dead() || world_.drive.faults.failures() > before, [&] {
      return fmt::format("{} fails only where the disk does: {}", name, error.what());
    });
  }
  if (world_.drive.dead()) {
    // Everybody learns of it at once, but not in the middle of what is being done here.
    later(0, [this] { kill(false); });
  }
  return did;
}

// ---- lives ----

void Coordinator::kill(bool power) {
  world_.tell("the coordinator {}", power ? "loses its power" : "ends");
  if (power) {
    world_.drive.cut_power();
  } else {
    world_.drive.kill();
  }
  ++life_;
  store_.reset();
  scheduler_.reset();
  armed_.reset();
  links_.clear();
  for (const auto& worker : world_.workers) {
    if (const Link link = worker->link()) world_.cut(link, false);
  }
  last_byte_.clear();
  held_.clear();
  idle_looks_.clear();
  excused_.clear();
  leases_.clear();
  out_.clear();
  doubted_.clear();
  arrived_.clear();
  films_.clear();
  paused_.clear();
  finishing_.clear();
  builds_.clear();
  focus_.clear();
  started_.clear();
  shortened_.clear();
  plans_.clear();
  passes_begun_.clear();
  late_.clear();
  offers_.clear();
  restoring_ = false;
  compacting_ = false;
  journal_.clear();
  syncing_ = false;
  later(world_.random.between(0.05, 4), [this] { start(); });
}

void Coordinator::start() {
  world_.drive.power_on();
  server::StoreSettings settings;
  settings.disk = {std::shared_ptr<void>(), &world_.drive};
  settings.segment_bytes = world_.segment_bytes;
  std::vector<server::JobRecord> records;
  const bool opened = done("a start", [&] {
    store_ = server::Store::open(data_folder, settings);
    records = store_->list_jobs();
    for (const server::JobRecord& record : records)
      if (record.state != "done") server::settle_frames(data_folder, record.id, world_.drive);
  });
  if (!opened) {
    if (!world_.drive.dead()) kill(false);
    return;
  }
  require(store_->damage().empty(), "each file that the index names is there");
  require(store_->epoch() > epoch_, "each start has an epoch of its own");
  epoch_ = store_->epoch();
  world_.tell("the coordinator starts: epoch {}", epoch_);
  require(!key_ || *key_ == store_->grant_key(), "the folder keeps its key");
  key_ = store_->grant_key();
  server::SchedulerSettings scheduling;
  scheduling.epoch = epoch_;
  scheduling.grant_key = {1, 2, 3};     // the store's is drawn anew in each run
  scheduling.deaths_alone = 1'000'000;  // crashes come at random here, and no task is to blame
  scheduler_ = std::make_unique<server::Scheduler>(scheduling);
  for (const server::JobRecord& record : records) restore(record);
  let_go_of_ended();
  for (const auto& [id, job] : world_.disk.jobs)
    require(std::any_of(records.begin(), records.end(),
                        [id = id](const auto& record) { return record.id == id; }),
            fmt::format("job {}, which was taken, is there", id));
}

void Coordinator::let_go_of_ended() {
  std::vector<JobId> left = store_->jobs_with_results();
  for (const JobId id : store_->jobs_with_checkpoints()) left.push_back(id);
  for (const JobId id : left)
    if (!world_.drive.dead() && !world_.disk.jobs.at(id).ended.empty())
      done("what is left of a job is let go", [&] { store_->end_job(id); });
}

void Coordinator::restore(const server::JobRecord& record) {
  const JobId id = record.id;
  // One whose taking was not answered may be there as well: then it is a job like any other.
  Disk::Job& job = world_.disk.jobs[id];
  const auto plan = std::make_shared<const JobPlan>(record.spec);
  require(!job.plan || job.plan->digest == plan->digest ||
              job.doubtful_samples.contains(plan->spec.render.samples),
          "a job keeps its plan, unless its time was up");
  job.plan = plan;
  if (!job.asked) job.asked = plan;
  job.doubtful_samples.clear();
  plans_[id] = plan->digest;
  focus_[id] = plan->spec.focus;
  const bool ended = record.state == "done" || record.state == "cancelled";
  require(job.ended.empty() || job.ended == record.state, "a job that has ended has ended so");
  require(!ended || !job.ended.empty() || job.doubtful_ends.contains(record.state),
          "a job has ended only if that was asked");
  check_shortened(id, job, record);
  if (ended) {
    job.ended = record.state;
    return;
  }
  job.files = server::frames_on_disk(data_folder, id, world_.drive);
  apply(scheduler_->add_job(id, job.plan, world_.events.now()));
  if (record.started > 0) {
    started_[id] = static_cast<double>(record.started - 1) / 1000;
    scheduler_->restore_started(
        id, world_.events.now() - from_seconds(world_.events.seconds_now() - started_[id]));
  }
  for (const auto& [frame, samples] : job.shortened)
    require(scheduler_->restore_shortened(id, frame, samples), [&, frame = frame] {
      return fmt::format("job {} frame {} ends where it was kept to", id, frame);
    });
  Films films;
  restoring_ = true;
  restore_checkpoints(id, job, films);
  restore_results(id, job, films);
  if (builds_.contains(id)) scheduler_->restore_build(id, builds_[id]);
  for (const auto& [frame, film] : films) film->restored();
  restoring_ = false;
  tell_folded(id, job, films);
}

void Coordinator::tell_folded(JobId id, const Disk::Job& job, const Films& films) {
  for (const auto& [frame, film] : films) {
    for (std::uint32_t tile = 0; tile < film->tile_count(); ++tile) {
      if (film->passes(tile) > 0)
        apply(scheduler_->tile_folded(id, frame, tile, film->passes(tile), world_.events.now()));
    }
  }
  for (const std::int32_t frame : job.files) {
    for (std::uint32_t tile = 0; tile < job.plan->grid.count(); ++tile)
      apply(scheduler_->tile_folded(id, frame, tile, passes_of(id, frame), world_.events.now()));
  }
}

void Coordinator::restore_checkpoints(JobId id, const Disk::Job& job, Films& films) {
  for (const server::Checkpoint& checkpoint : store_->checkpoints_of(id)) {
    for (const server::CheckpointTile& tile : checkpoint.tiles) {
      for (std::uint32_t pass = 0; pass < tile.passes; ++pass)
        require(job.results.contains({checkpoint.frame, tile.tile, pass}),
                "a checkpoint holds what was kept");
      passes_begun_[id] = std::max(passes_begun_[id], tile.passes);
      if (tile.passes > 0) begun(id, {checkpoint.frame, tile.tile, tile.passes - 1});
      apply(scheduler_->tile_folded(id, checkpoint.frame, tile.tile, tile.passes,
                                    world_.events.now()));
      if (job.files.contains(checkpoint.frame)) continue;
      server::FrameFilm*& film = films[checkpoint.frame];
      if (film == nullptr) film = &film_of(id, checkpoint.frame);
      film->restore_checkpoint(tile.tile, tile.passes,
                               {checkpoint.number, tile.offset, tile.length});
    }
  }
  for (const server::Tally& tally : store_->tallies_of(id)) builds_.emplace(id, tally.worker_build);
}

void Coordinator::restore_results(JobId id, Disk::Job& job, Films& films) {
  std::map<std::pair<std::int32_t, std::uint32_t>, std::uint32_t> held;  // passes in checkpoints
  for (const server::Checkpoint& checkpoint : store_->checkpoints_of(id))
    for (const server::CheckpointTile& tile : checkpoint.tiles)
      held[{checkpoint.frame, tile.tile}] = tile.passes;
  const auto in_checkpoint = [&](const TaskId& task) {
    const auto tile = held.find({task.frame, task.tile});
    return tile != held.end() && task.pass < tile->second;
  };
  std::map<TaskId, Bytes> found;
  store_->results_of(id, [&](const server::IndexedResult& result) {
    const auto known = job.results.find(result.task);
    auto bytes =
        std::make_shared<const std::vector<std::byte>>(store_->read_result(result.place).exr);
    if (known == job.results.end()) {
      require(*bytes == *bytes_of(render(*job.plan, result.task)),
              "a result that comes to light is its task's");
    } else {
      require(*bytes == *known->second, "a result is read back as it was kept");
    }
    require(!in_checkpoint(result.task) && found.emplace(result.task, std::move(bytes)).second,
            "a result is there once");
    passes_begun_[id] = std::max(passes_begun_[id], result.task.pass + 1);
    begun(id, result.task);
    scheduler_->restore_closed(id, result.task);
    builds_.emplace(id, result.worker_build);
    if (job.files.contains(result.task.frame)) return;
    server::FrameFilm*& film = films[result.task.frame];
    if (film == nullptr) film = &film_of(id, result.task.frame);
    film->restore(result.task.tile, result.task.pass, result.place);
  });
  for (const auto& [task, bytes] : job.results) {
    require(found.contains(task) || in_checkpoint(task), [&, &which = task] {
      return fmt::format("job {} {}, which was kept, is there", id, text_of(which));
    });
    found.emplace(task, bytes);
  }
  job.results = std::move(found);
}

// ---- results ----

void Coordinator::commit() {
  if (syncing_ || journal_.empty()) return;
  syncing_ = true;
  const std::vector<Arrived> group = std::exchange(journal_, {});
  if (world_.bug == Bug::acknowledge_before_commit) {
    for (const Arrived& arrived : group)
      world_.acknowledged.emplace(arrived.sent.job, arrived.sent.task);
  }
  later(world_.random.between(0.001, world_.weather.sync_most),
        [this, group] { append(group, 0.1); });
}

void Coordinator::append(const std::vector<Arrived>& group, double patience) {
  std::vector<server::NewResult> batch;
  for (const Arrived& arrived : group) {
    const server::WorkerInfo& worker = arrived.link->worker->info();
    server::NewResult result;
    result.info.job = arrived.sent.job;
    result.info.plan = world_.disk.jobs.at(arrived.sent.job).plan->digest;
    result.info.task = arrived.sent.task;
    result.info.lease = arrived.sent.lease;
    result.info.identity = worker.identity;
    result.worker_name = worker.name;
    result.worker_build = worker.build_id;
    result.exr = *arrived.bytes;
    batch.push_back(std::move(result));
  }
  std::vector<server::ResultPlace> places;
  done("an append", [&] { places = store_->append_results(batch); });
  // From here on they are there after any restart, whether anybody is told or not.
  if (!places.empty()) {
    for (const Arrived& arrived : group)
      if (world_.disk.jobs.at(arrived.sent.job).ended.empty())
        world_.disk.keep(arrived.sent.job, arrived.sent.task, arrived.bytes);
  }
  if (world_.drive.dead()) return;
  if (places.empty()) {
    later(patience, [this, group, patience] { append(group, std::min(2 * patience, 5.0)); });
    return;
  }
  std::vector<Arrived> kept = group;
  for (std::size_t i = 0; i < kept.size(); ++i) kept[i].place = places[i];
  later(world_.random.between(0, 0.002), [this, kept] {
    for (const Arrived& arrived : kept) durable(arrived);
    syncing_ = false;
    commit();
  });
}

void Coordinator::durable(const Arrived& arrived) {
  const auto& [link, worker, sent, bytes, tile, place] = arrived;
  arrived_.erase({sent.job, sent.task});
  Disk::Job& job = world_.disk.jobs.at(sent.job);
  if (job.ended.empty()) {
    world_.acknowledged.emplace(sent.job, sent.task);
    builds_.emplace(sent.job, link->worker->info().build_id);
  }
  world_.carry(link, false, [to = link, lease = sent.lease] { to->worker->answered(lease); });
  apply(scheduler_->result_durable(worker, sent.lease, sent.job, sent.task,
                                   job.plan->passes.pass(sent.task.pass).count, 0.1,
                                   world_.events.now()));
  if (!job.ended.empty() || job.files.contains(sent.task.frame)) return;
  film_of(sent.job, sent.task.frame).durable(sent.task.tile, sent.task.pass, place, tile);
  fold_on(sent.job, sent.task.frame, sent.task.tile);
}

}  // namespace tessera::sim
