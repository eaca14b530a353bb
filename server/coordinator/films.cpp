#include "server/coordinator/films.hpp"

#include <algorithm>
#include <boost/asio/post.hpp>

#include "common/base/error.hpp"

namespace tessera::server {

namespace {
/// Folds in one piece of the pool's work, so that others get their turn in between.
constexpr std::size_t folds_per_batch = 64;
}  // namespace

Films::Films(boost::asio::any_io_executor io, boost::asio::thread_pool& pool, int lanes, Crew& crew,
             ReadTile read, Hooks hooks)
    : io_(std::move(io)),
      pool_(pool),
      lanes_(static_cast<std::size_t>(std::max(1, lanes))),
      crew_(crew),
      read_(std::move(read)),
      hooks_(std::move(hooks)) {}

FrameFilm& Films::open(JobId job, const std::shared_ptr<const JobPlan>& plan, std::int32_t frame) {
  FramePtr& entry = frames_[{job, frame}];
  if (!entry) entry = std::make_shared<Frame>(job, plan, frame, io_);
  return entry->film;
}

const FrameFilm* Films::find(JobId job, std::int32_t frame) const {
  const auto found = frames_.find({job, frame});
  return found == frames_.end() ? nullptr : &found->second->film;
}

std::vector<std::int32_t> Films::frames(JobId job) const {
  std::vector<std::int32_t> numbers;
  for (auto it = frames_.lower_bound({job, INT32_MIN});
       it != frames_.end() && it->first.first == job; ++it)
    numbers.push_back(it->first.second);
  return numbers;
}

void Films::durable(JobId job, const std::shared_ptr<const JobPlan>& plan, const TaskId& task,
                    const ResultPlace& place, std::shared_ptr<const DecodedTile> decoded) {
  open(job, plan, task.frame).durable(task.tile, task.pass, place, std::move(decoded));
  touch(frames_[{job, task.frame}], task.tile);
}

void Films::touch(const FramePtr& frame, std::uint32_t tile) { touched_.emplace_back(frame, tile); }

void Films::flush() {
  std::vector<Fold> folds;
  for (const auto& [frame, tile] : touched_) {
    if (frame->gone) continue;
    if (auto work = frame->film.next(tile)) folds.push_back({frame, std::move(*work), nullptr, {}});
  }
  touched_.clear();
  const std::size_t share =
      std::clamp((folds.size() + lanes_ - 1) / lanes_, std::size_t{1}, folds_per_batch);
  for (std::size_t first = 0; first < folds.size(); first += share) {
    const std::size_t last = std::min(first + share, folds.size());
    const auto from = folds.begin() + static_cast<std::ptrdiff_t>(first);
    const auto to = folds.begin() + static_cast<std::ptrdiff_t>(last);
    post(std::make_shared<std::vector<Fold>>(std::make_move_iterator(from),
                                             std::make_move_iterator(to)));
  }
}

void Films::post(Batch batch) {
  crew_.begun();
  boost::asio::post(pool_, [this, batch = std::move(batch)] {
    for (Fold& one : *batch) fold(one);
    boost::asio::post(io_, [this, batch] {
      finish(batch);
      crew_.finished();
    });
  });
}

void Films::fold(Fold& fold) const {
  try {
    const JobPlan& plan = fold.frame->film.plan();
    const std::uint32_t tile = fold.work.tile;
    auto sums = fold.work.own;
    if (!sums)
      sums = std::make_shared<FilmTile>(fold.work.before ? *fold.work.before
                                                         : empty_film_tile(plan.grid.tile(tile)));
    for (const FoldWork::Pass& pass : fold.work.passes) {
      if (pass.tile) {
        server::fold(*sums, pass.tile->pixels);
      } else {
        const TaskId task{fold.frame->film.frame(), tile, pass.pass};
        server::fold(*sums, read_(pass.place, expectation_of(plan, task)).pixels);
      }
    }
    fold.folded = std::move(sums);
  } catch (const std::exception& error) {
    fold.error = error.what();
  }
}

void Films::finish(const Batch& batch) {
  for (Fold& one : *batch) {
    Frame& frame = *one.frame;
    if (frame.gone) continue;
    if (!one.error.empty()) {
      frame.error = one.error;
      hooks_.failed(frame.job, one.error);
    } else {
      if (frame.film.done(one.work, std::move(one.folded)))
        hooks_.folded(frame.job, frame.film.frame(), one.work.tile,
                      frame.film.passes(one.work.tile));
      touch(one.frame, one.work.tile);
    }
    frame.changed.notify();
  }
  batch->clear();
  flush();
  hooks_.settled();
}

boost::asio::awaitable<FilmSnapshot> Films::snapshot(JobId job, std::int32_t frame) {
  const auto found = frames_.find({job, frame});
  if (found == frames_.end()) throw Error(ErrorKind::not_found, "this frame has no film");
  const FramePtr held = found->second;
  bool asked = false;
  while (!held->film.loaded() && !held->gone && held->error.empty()) {
    held->film.demand();  // again, for another's snapshot may have ended it
    for (std::uint32_t tile = 0; !asked && tile < held->film.tile_count(); ++tile)
      touch(held, tile);
    asked = true;
    flush();
    co_await held->changed.wait();
  }
  if (!held->error.empty()) throw Error(ErrorKind::failed, held->error);
  if (!held->film.loaded()) throw Error(ErrorKind::not_found, "this frame's film was given up");
  co_return held->film.snapshot();
}

void Films::forget(JobId job, std::int32_t frame) {
  const auto found = frames_.find({job, frame});
  if (found == frames_.end()) return;
  found->second->gone = true;
  found->second->changed.notify();
  frames_.erase(found);
}

void Films::forget(JobId job) {
  for (const std::int32_t frame : frames(job)) forget(job, frame);
}

}  // namespace tessera::server
