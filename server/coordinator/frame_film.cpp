#include "server/coordinator/frame_film.hpp"

#include <algorithm>
#include <cassert>

namespace tessera::server {

image::TileExpectation expectation_of(const JobPlan& plan, const TaskId& task) {
  image::TileExpectation expected;
  expected.window = plan.grid.tile(task.tile);
  expected.film_width = plan.grid.film_width();
  expected.film_height = plan.grid.film_height();
  expected.samples = static_cast<std::uint32_t>(plan.passes.pass(task.pass).count);
  expected.aovs = plan.passes.has_aovs(task.pass, plan.spec.aov_samples);
  return expected;
}

DecodedTile decode(std::shared_ptr<const std::vector<std::byte>> exr,
                   const image::TileExpectation& expected) {
  image::TileView pixels = image::view_tile(*exr, expected);
  return {std::move(exr), std::move(pixels), nullptr};
}

FrameFilm::FrameFilm(std::shared_ptr<const JobPlan> plan, std::int32_t frame)
    : plan_(std::move(plan)), frame_(frame), film_(plan_->grid), tiles_(plan_->grid.count()) {}

void FrameFilm::restore(std::uint32_t tile, std::uint32_t pass, const ResultPlace& place) {
  tiles_[tile].waiting.push_back({pass, place, nullptr});
}

void FrameFilm::restored() {
  std::uint64_t version = 0;
  for (Tile& tile : tiles_) {
    std::sort(tile.waiting.begin(), tile.waiting.end(),
              [](const auto& a, const auto& b) { return a.pass < b.pass; });
    tile.folded = static_cast<std::uint32_t>(run_length(tile, 0));
    tile.unloaded = tile.folded > 0;
    unloaded_ += tile.unloaded ? 1 : 0;
    version += tile.folded;
  }
  film_ = Film(plan_->grid, version);
}

std::size_t FrameFilm::run_length(const Tile& tile, std::uint32_t first) {
  std::size_t length = 0;
  while (length < tile.waiting.size() && tile.waiting[length].pass == first + length) ++length;
  return length;
}

void FrameFilm::durable(std::uint32_t index, std::uint32_t pass, const ResultPlace& place,
                        std::shared_ptr<const DecodedTile> decoded) {
  Tile& tile = tiles_[index];
  if (pass < (tile.busy ? tile.busy_end : tile.folded)) return;
  const auto at = std::lower_bound(
      tile.waiting.begin(), tile.waiting.end(), pass,
      [](const FoldWork::Pass& entry, std::uint32_t value) { return entry.pass < value; });
  if (at != tile.waiting.end() && at->pass == pass) return;
  // In order if no pass between the film and this one is lacking.
  const auto before = static_cast<std::size_t>(at - tile.waiting.begin());
  const std::uint32_t next = tile.busy ? tile.busy_end : tile.folded;
  const bool in_order = !tile.unloaded && pass == next + before;
  tile.waiting.insert(at, {pass, place, in_order ? std::move(decoded) : nullptr});
}

std::optional<FoldWork> FrameFilm::next(std::uint32_t index) {
  Tile& tile = tiles_[index];
  if (tile.busy || tile.waiting.empty()) return std::nullopt;
  FoldWork work;
  work.tile = index;
  std::size_t count = 0;
  if (tile.unloaded) {
    const bool more = run_length(tile, 0) > tile.folded;
    if (!demanded_ && !more) return std::nullopt;
    work.loads = true;
    count = tile.folded;
  } else {
    count = run_length(tile, tile.folded);
    if (count == 0) return std::nullopt;
    if (!demanded_) work.own = film_.lend(index);
    if (work.own) {
      ++lent_;
    } else {
      work.before = film_.tile(index);
    }
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
    return false;
  }
  if (work.own) --lent_;
  film_.give_back(work.tile, std::move(folded));
  tile.folded = tile.busy_end;
  return true;
}

FilmSnapshot FrameFilm::snapshot() {
  assert(loaded());
  demanded_ = false;
  return film_.snapshot();
}

}  // namespace tessera::server
