#include "tests/sim/ledger.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "tests/sim/synthetic.hpp"

namespace tessera::sim {
namespace {

bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

/// Σ n·mean² of the channel whose deviations these are: what they were the difference to.
double deviations_of(const server::FilmTile& film, const image::Channel& moment2) {
  const double sum = film.sums.at(static_cast<std::size_t>(moment2.mean_of));
  return sum * sum / static_cast<double>(film.samples[static_cast<std::size_t>(moment2.group)]);
}

void audit_tile(const JobPlan& plan, std::int32_t frame, std::uint32_t tile,
                const server::FilmTile& film) {
  const std::string where = fmt::format("frame {} tile {}", frame, tile);
  require(film.passes == plan.passes.count(), where + " has every pass");
  require(film.samples[0] == static_cast<std::uint64_t>(plan.passes.samples()),
          where + " counts every sample exactly once");
  require(same_bits(film.sums, straight_fold(plan, frame, tile).sums),
          where + " has the straight fold's bits");
  const std::vector<double> plain = plain_sums(plan, frame, tile);
  const auto table = image::default_layout()->channels();
  for (std::size_t c = 0; c < plain.size(); ++c) {
    // Sums and least values to the bit; deviations as the rounding of another formula allows.
    const double far = table[c].merge == image::Merge::moment2
                           ? 1e-9 * (std::abs(plain[c]) + deviations_of(film, table[c]))
                           : 0;
    require(std::abs(film.sums.at(c) - plain[c]) <= far,
            [&] { return fmt::format("{} has plain loops' {}", where, table[c].name); });
  }
}

}  // namespace

void require(bool holds, const std::string& rule) {
  if (!holds) throw Violation(rule);
}

std::uint32_t Disk::passes_alone(JobId job, std::int32_t frame) {
  const auto [known, fresh] = alone.try_emplace({job, frame});
  if (fresh) known->second = sim::passes_alone(*jobs.at(job).asked, frame);
  return known->second;
}

void Disk::keep(JobId job, const TaskId& task, Bytes bytes) {
  const bool fresh = jobs.at(job).results.emplace(task, std::move(bytes)).second;
  require(fresh, [&] { return fmt::format("job {} {} is kept once", job, text_of(task)); });
}

namespace {

/// The plan of the frame as of a job of its own; where its noise was to end it, it did so where it
/// does when nothing disturbs it and no other frame is beside it.
JobPlan audited_plan(Disk& disk, JobId id, std::int32_t frame) {
  const Disk::Job& job = disk.jobs.at(id);
  JobSpec spec = job.plan->spec;
  if (const auto cut = job.shortened.find(frame); cut != job.shortened.end())
    spec.render.samples = cut->second;
  JobPlan plan(spec);
  if (spec.noise_threshold > 0 && spec.time_limit_seconds == 0)
    require(plan.passes.count() == disk.passes_alone(id, frame), [&] {
      return fmt::format("job {} frame {} ends after as many passes as alone: {} of {}", id, frame,
                         plan.passes.count(), disk.passes_alone(id, frame));
    });
  return plan;
}

}  // namespace

void audit(Disk& disk, const Acknowledged& acknowledged, const ReadPicture& read) {
  for (const auto& [id, job] : disk.jobs) {
    require(!job.ended.empty(), fmt::format("job {} has come to an end", id));
    require(job.ended != "failed", fmt::format("job {} did not fail", id));
    if (job.ended != "done") continue;
    const FrameList& frames = job.plan->spec.frames;
    for (std::uint32_t index = 0; index < frames.count(); ++index) {
      const std::int32_t frame = frames.number(index);
      const std::vector<server::FilmTile> tiles = read(id, frame);
      require(tiles.size() == job.plan->grid.count(),
              fmt::format("job {} frame {} has a whole picture", id, frame));
      const JobPlan plan = audited_plan(disk, id, frame);
      for (std::uint32_t tile = 0; tile < job.plan->grid.count(); ++tile)
        audit_tile(plan, frame, tile, tiles[tile]);
    }
  }
  for (const auto& [job, task] : acknowledged) {
    require(disk.jobs.at(job).results.contains(task),
            fmt::format("job {} {}, which was acknowledged, is there", job, text_of(task)));
  }
}

}  // namespace tessera::sim
