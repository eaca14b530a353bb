// Frames that their noise ends: the real film is looked at, some time after that was asked for.
#include <fmt/format.h>

#include <algorithm>

#include "server/film/noise.hpp"
#include "server/schedule/noise_stop.hpp"
#include "tests/sim/coordinator.hpp"

namespace tessera::sim {
namespace {

/// No pass of it is handed out beyond a look.
bool waits_for_looks(const JobSpec& job) {
  return job.noise_threshold > 0 && job.time_limit_seconds == 0;
}

}  // namespace

std::uint32_t Coordinator::passes_of(JobId id, std::int32_t frame) const {
  const Disk::Job& job = world_.disk.jobs.at(id);
  const auto cut = job.shortened.find(frame);
  return cut == job.shortened.end() ? job.plan->passes.count()
                                    : server::passes_within(job.plan->passes, cut->second);
}

std::uint32_t Coordinator::offered(JobId id, std::int32_t frame) const {
  const JobPlan& plan = *world_.disk.jobs.at(id).plan;
  if (!waits_for_looks(plan.spec)) return plan.passes.count();
  const auto raised = offers_.find({id, frame});
  const std::uint32_t first = server::next_look(plan.passes, 1);
  return raised == offers_.end() ? first : std::max(first, raised->second);
}

void Coordinator::begun(JobId id, const TaskId& task) {
  const JobPlan& plan = *world_.disk.jobs.at(id).plan;
  if (!waits_for_looks(plan.spec)) return;
  require(task.pass < world_.disk.passes_alone(id, task.frame), [&] {
    return fmt::format("job {} {} is of a pass that its frame has alone", id, text_of(task));
  });
  std::uint32_t& raised = offers_[{id, task.frame}];
  raised = std::max(raised, server::next_look(plan.passes, task.pass + 1));
}

void Coordinator::shortened(const server::FrameShortened& cut) {
  Disk::Job& job = world_.disk.jobs.at(cut.job);
  const std::string what = fmt::format("job {} frame {}", cut.job, cut.frame);
  require(job.plan->spec.noise_threshold > 0 && job.plan->spec.frames.count() > 1,
          what + " is one of several that noise may end");
  const PassPlan& passes = job.plan->passes;
  require(cut.samples < passes.samples() &&
              passes.pass(server::passes_within(passes, cut.samples) - 1).end() == cut.samples,
          what + " ends at a whole pass before the last");
  const auto [known, fresh] = job.said.emplace(cut.frame, cut.samples);
  require(fresh || known->second == cut.samples, what + " is shortened in one way");
}

void Coordinator::check_shortened(JobId id, Disk::Job& job, const server::JobRecord& record) {
  for (const auto& [frame, samples] : job.shortened)
    require(record.shortened_frames.contains(frame), [&, frame = frame] {
      return fmt::format("job {} frame {}, whose end was kept, has it", id, frame);
    });
  for (const auto& [frame, samples] : record.shortened_frames) {
    const auto said = job.said.find(frame);
    require(said != job.said.end() && said->second == samples, [&, frame = frame] {
      return fmt::format("job {} frame {} ended as is found", id, frame);
    });
  }
  job.shortened = record.shortened_frames;
}

void Coordinator::asked(const server::MeasureNoise& look) {
  const server::FrameFilm& film = film_of(look.job, look.frame);
  // While a start reads back what there is, less is known: then the answer comes to nothing.
  for (std::uint32_t tile = 0; tile < film.tile_count() && !restoring_; ++tile)
    require(film.passes(tile) == look.passes, [&] {
      return fmt::format("job {} frame {} is looked at when all its tiles have {} passes", look.job,
                         look.frame, look.passes);
    });
  later(world_.random.between(0, 4 * world_.weather.fold_most), [this, look] { this->look(look); });
}

void Coordinator::look(const server::MeasureNoise& look) {
  const Disk::Job& job = world_.disk.jobs.at(look.job);
  if (!job.ended.empty() || world_.drive.dead() || job.files.contains(look.frame)) return;
  server::FrameFilm& film = film_of(look.job, look.frame);
  if (!film.loaded()) {
    demand(look.job, look.frame);
    later(0.05, [this, look] { this->look(look); });
    return;
  }
  const double noise = server::noise_of(film.snapshot());
  // The answer takes its time, too: late results of earlier lives may come before it.
  later(world_.random.between(0, 0.05), [this, look, noise] {
    const Disk::Job& to = world_.disk.jobs.at(look.job);
    if (!to.ended.empty()) return;
    if (noise > to.plan->spec.noise_threshold) begun(look.job, {look.frame, 0, look.passes});
    apply(
        scheduler_->noise_measured(look.job, look.frame, look.passes, noise, world_.events.now()));
  });
}

}  // namespace tessera::sim
