// Which pass is folded when is decided by the real FrameFilm; the folds take their time.
#include <algorithm>

#include "server/coordinator/job_content.hpp"
#include "server/film/film_tile_bytes.hpp"
#include "tests/sim/coordinator.hpp"
#include "tests/sim/synthetic.hpp"

namespace tessera::sim {

server::FrameFilm& Coordinator::film_of(JobId job, std::int32_t frame) {
  return films_.try_emplace({job, frame}, world_.disk.jobs.at(job).plan, frame).first->second;
}

std::uint32_t Coordinator::folded(JobId job, const TaskId& task) const {
  const Disk::Job& known = world_.disk.jobs.at(job);
  if (known.files.contains(task.frame)) return passes_of(job, task.frame);
  const auto film = films_.find({job, task.frame});
  return film == films_.end() ? 0 : film->second.passes(task.tile);
}

void Coordinator::fold_on(JobId id, std::int32_t frame, std::uint32_t tile) {
  if (const auto work = film_of(id, frame).next(tile)) {
    later(world_.random.between(0, world_.weather.fold_most),
          [this, id, frame, work = *work] { fold(id, frame, work); });
  }
}

void Coordinator::fold(JobId id, std::int32_t frame, const server::FoldWork& work) {
  const Disk::Job& job = world_.disk.jobs.at(id);
  if (!job.ended.empty() || world_.drive.dead()) return;
  server::FrameFilm& film = film_of(id, frame);
  if (film.done(work, folded_by(id, frame, work))) {
    compact_in_time(id, frame);
    const std::uint32_t passes = film.passes(work.tile);
    apply(scheduler_->tile_folded(id, frame, work.tile,
                                  passes + (world_.bug == Bug::ignore_fold_limit ? 1 : 0),
                                  world_.events.now()));
  }
  if (films_.contains({id, frame})) fold_on(id, frame, work.tile);
}

std::shared_ptr<server::FilmTile> Coordinator::folded_by(JobId id, std::int32_t frame,
                                                         const server::FoldWork& work) {
  const JobPlan& plan = *world_.disk.jobs.at(id).plan;
  auto sums = work.own;
  if (!sums)
    sums = std::make_shared<server::FilmTile>(
        work.before ? *work.before : server::empty_film_tile(plan.grid.tile(work.tile)));
  if (work.checkpoint)
    *sums = server::film_tile_from(store_->read_checkpoint(*work.checkpoint),
                                   plan.grid.tile(work.tile), image::default_layout());
  std::vector<server::FoldWork::Pass> passes = work.passes;
  if (world_.bug == Bug::fold_out_of_order && passes.size() > 1) std::swap(passes[0], passes[1]);
  if (world_.bug == Bug::double_fold && sums->passes == 1) passes.push_back(passes.back());
  for (const server::FoldWork::Pass& pass : passes) {
    if (pass.tile) {
      server::fold(*sums, pass.tile->pixels);
    } else {
      const auto bytes =
          std::make_shared<const std::vector<std::byte>>(store_->read_result(pass.place).exr);
      server::fold(*sums, decode(bytes, plan, {frame, work.tile, pass.pass}).pixels);
    }
  }
  return sums;
}

// ---- films on disk ----

void Coordinator::demand(JobId id, std::int32_t frame) {
  server::FrameFilm& film = film_of(id, frame);
  film.demand();
  for (std::uint32_t tile = 0; tile < film.tile_count(); ++tile) fold_on(id, frame, tile);
}

void Coordinator::compact_in_time(JobId id, std::int32_t frame) {
  server::FrameFilm& film = film_of(id, frame);
  if (compacting_) return;
  if (film.journal_bytes() > world_.compact_bytes) {
    compacting_ = true;
    later(0, [this, id, frame] { compact(id, frame); });
  } else if (!film.demanded() && world_.random.chance(0.02)) {
    film.drop();
  }
}

void Coordinator::compact(JobId id, std::int32_t frame) {
  const Disk::Job& job = world_.disk.jobs.at(id);
  if (!job.ended.empty() || job.files.contains(frame)) {
    compacting_ = false;
    return;
  }
  server::FrameFilm& film = film_of(id, frame);
  if (!film.loaded()) {
    demand(id, frame);
    later(0.05, [this, id, frame] { compact(id, frame); });
    return;
  }
  // Written while it is folded on.
  later(world_.random.between(0, 4 * world_.weather.fold_most),
        [this, id, frame, kept = film.snapshot()] { keep_whole(id, frame, kept); });
}

void Coordinator::keep_whole(JobId id, std::int32_t frame, const server::FilmSnapshot& film) {
  compacting_ = false;
  const Disk::Job& job = world_.disk.jobs.at(id);
  const bool ends = std::any_of(film.tiles.begin(), film.tiles.end(), [&](const auto& tile) {
    return tile && tile->passes > job.plan->passes.regular();
  });
  if (ends || !job.ended.empty() || job.files.contains(frame)) return;
  server::Checkpoint made;
  const bool written = done("a checkpoint's file",
                            [&] { made = server::write_checkpoint(*store_, id, frame, film); });
  if (!written) return;
  bool put = false;
  done("a checkpoint", [&] { store_->put_checkpoint(made), put = true; });
  if (!put || world_.drive.dead()) return;
  world_.tell("job {} frame {} has a checkpoint of {} tiles", id, frame, made.tiles.size());
  film_of(id, frame).checkpointed(made);
  ++world_.checkpoints;
}

}  // namespace tessera::sim
