#include "tests/sim/ledger.hpp"

#include <fmt/format.h>

#include <cstring>

#include "tests/sim/synthetic.hpp"

namespace tessera::sim {
namespace {

bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

void audit_tile(const JobPlan& plan, std::int32_t frame, std::uint32_t tile,
                const server::FilmTile& film) {
  const std::string where = fmt::format("frame {} tile {}", frame, tile);
  require(film.passes == plan.passes.count(), where + " has every pass");
  require(film.samples[0] == static_cast<std::uint64_t>(plan.passes.samples()),
          where + " counts every sample exactly once");
  require(same_bits(film.sums, straight_fold(plan, frame, tile).sums),
          where + " has the straight fold's bits");
  require(film.sums.at(image::R) == red_sum(plan, frame, tile),
          where + " has the red sum of a plain loop");
}

}  // namespace

void require(bool holds, const std::string& rule) {
  if (!holds) throw Violation(rule);
}

void Disk::keep(JobId job, const TaskId& task, Bytes bytes) {
  const bool fresh = jobs.at(job).results.emplace(task, std::move(bytes)).second;
  require(fresh, [&] { return fmt::format("job {} {} is kept once", job, text_of(task)); });
}

void audit(const Disk& disk, const Acknowledged& acknowledged, const ReadPicture& read) {
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
      for (std::uint32_t tile = 0; tile < job.plan->grid.count(); ++tile)
        audit_tile(*job.plan, frame, tile, tiles[tile]);
    }
  }
  for (const auto& [job, task] : acknowledged) {
    require(disk.jobs.at(job).results.contains(task),
            fmt::format("job {} {}, which was acknowledged, is there", job, text_of(task)));
  }
}

}  // namespace tessera::sim
