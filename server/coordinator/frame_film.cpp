#include "server/coordinator/frame_film.hpp"

#include <algorithm>
#include <cassert>

#include "server/film/film_tile_bytes.hpp"

namespace tessera::server {

image::TileExpectation expectation_of(const JobPlan& plan, const TaskId& task) {
  image::TileExpectation expected;
  expected.window = plan.grid.tile(task.tile);
  expected.film_width = plan.grid.film_width();
  expected.film_height = plan.grid.film_height();
  expected.samples = static_cast<std::uint32_t>(plan.passes.pass(task.pass).count);
  expected.aovs = plan.passes.has_aovs(task.pass, plan.spec.aov_samples);
  expected.layout = image::layout_of(plan.spec.render.aovs);
  return expected;
}

DecodedTile decode(std::shared_ptr<const std::vector<std::byte>> exr,
                   const image::TileExpectation& expected) {
  image::TileView pixels = image::view_tile(*exr, expected);
  return {std::move(exr), std::move(pixels), nullptr};
}

FrameFilm::FrameFilm(std::shared_ptr<const JobPlan> plan, std::int32_t frame, std::uint64_t version)
    : plan_(std::move(plan)),
      frame_(frame),
      layout_(image::layout_of(plan_->spec.render.aovs)),
      film_(plan_->grid, version, layout_),
      tiles_(plan_->grid.count()) {}

std::size_t FrameFilm::bytes_of(std::uint32_t tile) const {
  return film_bytes(plan_->grid.tile(tile).pixels(), *layout_);
}

// ---- after a start ----

void FrameFilm::restore_checkpoint(std::uint32_t index, std::uint32_t passes,
                                   const CheckpointPlace& place) {
  Tile& tile = tiles_[index];
  tile.kept = passes;
  tile.checkpoint = place;
}

void FrameFilm::restore(std::uint32_t tile, std::uint32_t pass, const ResultPlace& place) {
  tiles_[tile].waiting.push_back({pass, place, nullptr});
}

void FrameFilm::restored() {
  std::uint64_t version = film_.version();
  for (Tile& tile : tiles_) {
    std::erase_if(tile.waiting, [&](const auto& entry) { return entry.pass < tile.kept; });
    std::sort(tile.waiting.begin(), tile.waiting.end(),
              [](const auto& a, const auto& b) { return a.pass < b.pass; });
    const std::size_t run = run_length(tile, tile.kept);
    for (std::size_t i = 0; i < run; ++i) {
      tile.places.push_back(tile.waiting[i].place);
      journal_bytes_ += tile.places.back().length;
    }
    tile.waiting.erase(tile.waiting.begin(),
                       tile.waiting.begin() + static_cast<std::ptrdiff_t>(run));
    tile.folded = tile.kept + static_cast<std::uint32_t>(run);
    tile.unloaded = tile.folded > 0;
    unloaded_ += tile.unloaded ? 1 : 0;
    irregular_ += tile.folded > plan_->passes.regular() ? 1 : 0;
    version += tile.folded;
  }
  film_ = Film(plan_->grid, version, layout_);
}

// ---- folding ----

std::size_t FrameFilm::run_length(const Tile& tile, std::uint32_t first) {
  std::size_t length = 0;
  while (length < tile.waiting.size() && tile.waiting[length].pass == first + length) ++length;
  return length;
}

void FrameFilm::durable(std::uint32_t index, std::uint32_t pass, const ResultPlace& place,
                        std::shared_ptr<const DecodedTile> decoded) {
  Tile& tile = tiles_[index];
  const std::uint32_t next = tile.busy ? tile.busy_end : tile.folded;
  if (pass < next) return;
  const auto at = std::lower_bound(
      tile.waiting.begin(), tile.waiting.end(), pass,
      [](const FoldWork::Pass& entry, std::uint32_t value) { return entry.pass < value; });
  if (at != tile.waiting.end() && at->pass == pass) return;
  // In order if no pass between the film and this one is lacking.
  const auto before = static_cast<std::size_t>(at - tile.waiting.begin());
  const bool in_order = !tile.unloaded && pass == next + before;
  tile.waiting.insert(at, {pass, place, in_order ? std::move(decoded) : nullptr});
}

std::optional<FoldWork> FrameFilm::next(std::uint32_t index) {
  Tile& tile = tiles_[index];
  if (tile.busy) return std::nullopt;
  const std::size_t count = run_length(tile, tile.folded);
  FoldWork work;
  work.tile = index;
  if (tile.unloaded) {
    if (!demanded_ && count == 0) return std::nullopt;
    work.loads = true;
    if (tile.kept > 0) work.checkpoint = tile.checkpoint;
    for (const ResultPlace& place : tile.places)
      work.passes.push_back(
          {tile.kept + static_cast<std::uint32_t>(work.passes.size()), place, nullptr});
    tile.busy_end = tile.folded;
    tile.busy = true;
    return work;
  }
  if (count == 0) return std::nullopt;
  if (!demanded_) work.own = film_.lend(index);
  if (work.own) {
    ++lent_;
  } else {
    work.before = film_.tile(index);
  }
  const auto end = tile.waiting.begin() + static_cast<std::ptrdiff_t>(count);
  work.passes.assign(std::make_move_iterator(tile.waiting.begin()), std::make_move_iterator(end));
  tile.waiting.erase(tile.waiting.begin(), end);
  tile.busy_end = work.passes.back().pass + 1;
  tile.busy = true;
  return work;
}

void FrameFilm::demand() { demanded_ = true; }

bool FrameFilm::done(const FoldWork& work, std::shared_ptr<FilmTile> folded) {
  Tile& tile = tiles_[work.tile];
  assert(tile.busy && folded);
  tile.busy = false;
  if (work.loads) {
    film_.restore(work.tile, std::move(folded));
    tile.unloaded = false;
    --unloaded_;
    memory_ += bytes_of(work.tile);
    return false;
  }
  if (work.own) --lent_;
  if (tile.folded == 0) memory_ += bytes_of(work.tile);
  film_.give_back(work.tile, std::move(folded));
  for (const FoldWork::Pass& pass : work.passes) {
    tile.places.push_back(pass.place);
    journal_bytes_ += pass.place.length;
  }
  const std::uint32_t regular = plan_->passes.regular();
  irregular_ += tile.folded <= regular && tile.busy_end > regular ? 1 : 0;
  tile.folded = tile.busy_end;
  return true;
}

std::int64_t FrameFilm::samples() const {
  std::int64_t all = 0;
  for (std::uint32_t index = 0; index < tiles_.size(); ++index)
    if (const std::uint32_t folded = tiles_[index].folded; folded > 0)
      all += plan_->grid.tile(index).pixels() * plan_->passes.pass(folded - 1).end();
  return all;
}

FilmSnapshot FrameFilm::snapshot() {
  assert(loaded());
  demanded_ = false;
  return film_.snapshot();
}

// ---- keeping ----

void FrameFilm::checkpointed(const Checkpoint& checkpoint) {
  for (const CheckpointTile& kept : checkpoint.tiles) {
    Tile& tile = tiles_[kept.tile];
    assert(kept.passes >= tile.kept && kept.passes <= tile.folded);
    const auto end = tile.places.begin() + static_cast<std::ptrdiff_t>(kept.passes - tile.kept);
    for (auto place = tile.places.begin(); place != end; ++place) journal_bytes_ -= place->length;
    tile.places.erase(tile.places.begin(), end);
    tile.kept = kept.passes;
    tile.checkpoint = {checkpoint.number, kept.offset, kept.length};
  }
}

void FrameFilm::drop() {
  assert(!demanded_);
  for (std::uint32_t index = 0; index < tiles_.size(); ++index) {
    Tile& tile = tiles_[index];
    if (tile.busy || tile.unloaded || tile.folded == 0) continue;
    film_.unload(index);
    tile.unloaded = true;
    ++unloaded_;
    memory_ -= bytes_of(index);
  }
}

}  // namespace tessera::server
