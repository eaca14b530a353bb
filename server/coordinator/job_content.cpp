#include "server/coordinator/job_content.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <tuple>

#include "common/base/error.hpp"
#include "server/coordinator/frame_film.hpp"
#include "server/film/film_tile_bytes.hpp"
#include "server/store/damaged.hpp"

namespace tessera::server {

JobContent read_job(const Store& store, JobId job) {
  JobContent content;
  content.checkpoints = store.checkpoints_of(job);
  content.tallies = store.tallies_of(job);
  using Key = std::tuple<std::string, std::string, Digest>;
  std::map<Key, Tally> live;
  store.results_of(job, [&](const IndexedResult& result) {
    content.results.emplace_back(result.task, result.place);
    Tally& tally = live[{result.worker_name, result.identity, result.worker_build}];
    tally.worker_name = result.worker_name;
    tally.worker_build = result.worker_build;
    tally.samples += result.samples;
    tally.rays += result.rays;
    tally.rejected += result.rejected;
    tally.cpu_seconds += result.cpu_seconds;
  });
  for (auto& [key, tally] : live) content.tallies.push_back(std::move(tally));
  return content;
}

namespace {

/// What was read is whole, for its CRC is right; that it is no tile all the same does not change.
template <class Parse>
auto parsed(const Parse& parse) {
  try {
    return parse();
  } catch (const Error& error) {
    throw DamagedError(error.what());
  }
}

void stop_if(const std::function<bool()>& stopped) {
  if (stopped()) throw Error(ErrorKind::failed, "the coordinator stops");
}

/// What is kept of one finished frame's regular passes.
class KeptFrame {
 public:
  KeptFrame(const Store& store, const SettleInput& of) : store_(store), of_(of) {
    if (const auto before = store.checkpoint_of(of.job, of.frame))
      for (const CheckpointTile& tile : before->tiles)
        checkpointed_[tile.tile] = {tile.passes,
                                    CheckpointPlace{before->number, tile.offset, tile.length}};
    store.results_of(of.job, of.frame, [&](const IndexedResult& result) {
      if (result.task.pass < regular_)
        results_[{result.task.tile, result.task.pass}] = result.place;
    });
  }

  /// There is no result that a checkpoint of all regular passes would take the place of.
  [[nodiscard]] bool whole() const {
    if (!results_.empty() || checkpointed_.size() != of_.plan->grid.count()) return false;
    for (const auto& [tile, held] : checkpointed_)
      if (held.first < regular_) return false;
    return true;
  }

  [[nodiscard]] FilmTile tile(std::uint32_t index) const {
    const JobPlan& plan = *of_.plan;
    const Rect window = plan.grid.tile(index);
    const auto held = checkpointed_.find(index);
    FilmTile sums = empty_film_tile(window, layout_);
    if (held != checkpointed_.end()) {
      const std::vector<std::byte> bytes = store_.read_checkpoint(held->second.second);
      sums = parsed([&] { return film_tile_from(bytes, window, layout_); });
    }
    while (sums.passes < regular_) {
      const TaskId task{of_.frame, index, sums.passes};
      const auto place = results_.find({index, sums.passes});
      if (place == results_.end()) throw DamagedError(fmt::format("{} is not kept", text_of(task)));
      auto exr =
          std::make_shared<const std::vector<std::byte>>(store_.read_result(place->second).exr);
      fold(sums, parsed([&] { return decode(std::move(exr), expectation_of(plan, task)); }).pixels);
    }
    return sums;
  }

 private:
  const Store& store_;
  const SettleInput& of_;
  std::uint32_t regular_ = std::min(of_.passes, of_.plan->passes.regular());
  image::Layout layout_ = image::layout_of(of_.plan->spec.render.aovs);
  std::map<std::uint32_t, std::pair<std::uint32_t, CheckpointPlace>> checkpointed_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, ResultPlace> results_;
};

}  // namespace

void check_readable(const Store& store, const JobContent& content,
                    const std::function<bool()>& stopped) {
  for (const Checkpoint& checkpoint : content.checkpoints)
    for (const CheckpointTile& tile : checkpoint.tiles) {
      stop_if(stopped);
      static_cast<void>(store.read_checkpoint({checkpoint.number, tile.offset, tile.length}));
    }
  for (const auto& [task, place] : content.results) {
    stop_if(stopped);
    static_cast<void>(store.read_result(place));
  }
}

std::optional<Checkpoint> settle(const Store& store, const SettleInput& input,
                                 const std::function<bool()>& stopped) {
  const KeptFrame kept(store, input);
  if (kept.whole()) return std::nullopt;
  const auto writer = store.begin_checkpoint(input.job, input.frame);
  for (std::uint32_t index = 0; index < input.plan->grid.count(); ++index) {
    stop_if(stopped);
    const FilmTile sums = kept.tile(index);
    writer->append(index, sums.passes, bytes_of(sums));
  }
  return writer->finish();
}

Checkpoint write_checkpoint(const Store& store, JobId job, std::int32_t frame,
                            const FilmSnapshot& film) {
  const auto writer = store.begin_checkpoint(job, frame);
  for (std::uint32_t index = 0; index < film.tiles.size(); ++index)
    if (const auto& tile = film.tiles[index]) writer->append(index, tile->passes, bytes_of(*tile));
  return writer->finish();
}

}  // namespace tessera::server
