// Which pass is folded when is decided by the real FrameFilm; the folds take their time.
#include "tests/sim/coordinator.hpp"
#include "tests/sim/synthetic.hpp"

namespace tessera::sim {

server::FrameFilm& Coordinator::film_of(JobId job, std::int32_t frame) {
  return films_.try_emplace({job, frame}, world_.disk.jobs.at(job).plan, frame).first->second;
}

std::uint32_t Coordinator::folded(JobId job, const TaskId& task) const {
  const Disk::Job& known = world_.disk.jobs.at(job);
  if (known.files.contains(task.frame)) return known.plan->passes.count();
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

}  // namespace tessera::sim
