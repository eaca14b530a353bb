#include "server/coordinator/films.hpp"

#include <algorithm>
#include <array>
#include <boost/asio/post.hpp>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "server/coordinator/film_memory.hpp"
#include "server/film/film_tile_bytes.hpp"

namespace tessera::server {

namespace {
/// Folds in one piece of the pool's work, so that others get their turn in between.
constexpr std::size_t folds_per_batch = 64;
/// Pauses before what could not be read back is tried again.
constexpr std::array<Duration, 3> retries = {std::chrono::milliseconds(100),
                                             std::chrono::milliseconds(400),
                                             std::chrono::milliseconds(1600)};
}  // namespace

Films::Films(boost::asio::any_io_executor io, boost::asio::thread_pool& pool, int lanes, Crew& crew,
             std::uint64_t memory_most, Source source, Hooks hooks)
    : io_(std::move(io)),
      pool_(pool),
      lanes_(static_cast<std::size_t>(std::max(1, lanes))),
      crew_(crew),
      memory_most_(memory_most),
      source_(std::move(source)),
      hooks_(std::move(hooks)) {}

FrameFilm& Films::open(JobId job, const std::shared_ptr<const JobPlan>& plan, std::int32_t frame,
                       std::uint64_t version) {
  FramePtr& entry = frames_[{job, frame}];
  if (!entry) entry = std::make_shared<Frame>(job, plan, frame, version, io_);
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

void Films::durable(JobId job, const std::shared_ptr<const JobPlan>& plan, std::uint64_t version,
                    const TaskId& task, const ResultPlace& place,
                    std::shared_ptr<const DecodedTile> decoded) {
  open(job, plan, task.frame, version).durable(task.tile, task.pass, place, std::move(decoded));
  touch(frames_[{job, task.frame}], task.tile);
}

void Films::touch(const FramePtr& frame, std::uint32_t tile) { touched_.emplace_back(frame, tile); }

void Films::flush() {
  std::vector<Fold> folds;
  const std::uint64_t most = memory_most_ / 4;
  for (; !touched_.empty(); touched_.pop_front()) {
    const auto& [frame, tile] = touched_.front();
    if (frame->gone) continue;
    const FrameFilm& film = frame->film;
    const std::uint64_t bytes = film_bytes(film.plan().grid.tile(tile).pixels(), *film.layout());
    // Tiles under way stay in memory whatever is dropped, and where the pool does not keep up each
    // result would bring in another.
    if (folding_ > 0 && folding_ + bytes > most) break;
    auto work = frame->film.next(tile);
    if (!work) continue;
    folding_ += bytes;
    folds.push_back({frame, std::move(*work), bytes, nullptr, {}});
  }
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

std::shared_ptr<FilmTile> Films::begin(const FrameFilm& film, const FoldWork& work) const {
  if (work.own) return work.own;
  const Rect window = film.plan().grid.tile(work.tile);
  if (work.checkpoint)
    return std::make_shared<FilmTile>(source_.checkpoint(*work.checkpoint, window, film.layout()));
  return std::make_shared<FilmTile>(work.before ? *work.before
                                                : empty_film_tile(window, film.layout()));
}

void Films::fold(Fold& fold) const {
  try {
    const JobPlan& plan = fold.frame->film.plan();
    const std::uint32_t tile = fold.work.tile;
    auto sums = begin(fold.frame->film, fold.work);
    for (const FoldWork::Pass& pass : fold.work.passes) {
      if (sums == fold.work.own && pass.pass < sums->passes) continue;  // by an earlier try
      if (sums->passes != pass.pass)
        throw Error(ErrorKind::failed, "what is kept of a film does not follow on itself");
      if (pass.tile) {
        server::fold(*sums, pass.tile->pixels);
      } else {
        const TaskId task{fold.frame->film.frame(), tile, pass.pass};
        server::fold(*sums, source_.result(pass.place, expectation_of(plan, task)).pixels);
      }
    }
    fold.folded = std::move(sums);
    fold.error.clear();
  } catch (const std::exception& error) {
    fold.error = error.what();
  }
}

void Films::finish(const Batch& batch) {
  std::vector<Fold> failed;
  for (Fold& one : *batch) {
    Frame& frame = *one.frame;
    if (!frame.gone && !one.error.empty() && one.tries < retries.size() && !crew_.stopping()) {
      log::warn("job {} frame {}: its film could not be read back: {}", frame.job,
                frame.film.frame(), one.error);
      failed.push_back(std::move(one));
      continue;
    }
    folding_ -= one.bytes;
    if (frame.gone) continue;
    if (!one.error.empty()) {
      frame.error = one.error;
      hooks_.failed(frame.job, one.error);
    } else {
      frame.used = ++clock_;
      const std::size_t before = frame.film.memory();
      const bool grown = frame.film.done(one.work, std::move(one.folded));
      memory_ += frame.film.memory() - before;
      if (grown)
        hooks_.folded(frame.job, frame.film.frame(), one.work.tile,
                      frame.film.passes(one.work.tile));
      // What was read back for a pass takes it in at once: it might be dropped before its next
      // turn.
      if (one.work.loads) {
        touched_.emplace_front(one.frame, one.work.tile);
      } else {
        touch(one.frame, one.work.tile);
      }
    }
    frame.changed.notify();
  }
  if (!failed.empty())
    crew_.start("a fold", fold_again(std::make_shared<std::vector<Fold>>(std::move(failed))));
  batch->clear();
  trim();
  flush();
  hooks_.settled();
}

boost::asio::awaitable<void> Films::fold_again(Batch batch) {
  std::size_t tries = retries.size() - 1;
  for (Fold& one : *batch) tries = std::min(tries, one.tries++);
  co_await crew_.pause(retries[tries]);
  post(std::move(batch));
}

void Films::trim() {
  if (memory_ <= memory_most_) return;
  std::vector<FramePtr> frames;
  std::vector<FilmUse> uses;
  for (const auto& [key, frame] : frames_) {
    frames.push_back(frame);
    uses.push_back({frame->film.memory(), frame->used, frame->holds > 0 || frame->film.demanded()});
  }
  for (const std::size_t index : films_to_drop(uses, memory_most_)) {
    Frame& frame = *frames[index];
    const std::size_t before = frame.film.memory();
    frame.film.drop();
    memory_ -= before - frame.film.memory();
    log::debug("job {} frame {}: {} bytes of its film leave memory", frame.job, frame.film.frame(),
               before - frame.film.memory());
  }
}

boost::asio::awaitable<FilmSnapshot> Films::snapshot(JobId job, std::int32_t frame) {
  const auto found = frames_.find({job, frame});
  if (found == frames_.end()) throw Error(ErrorKind::not_found, "this frame has no film");
  const FramePtr held = found->second;
  while (!held->film.loaded() && !held->gone && held->error.empty()) {
    if (!held->film.demanded()) {  // again, if another's snapshot has ended it
      held->film.demand();
      for (std::uint32_t tile = 0; tile < held->film.tile_count(); ++tile) touch(held, tile);
    }
    flush();
    co_await held->changed.wait();
  }
  if (!held->error.empty()) throw Error(ErrorKind::failed, held->error);
  if (!held->film.loaded()) throw Error(ErrorKind::not_found, "this frame's film was given up");
  co_return held->film.snapshot();
}

void Films::checkpointed(const Checkpoint& checkpoint) {
  const auto found = frames_.find({checkpoint.job, checkpoint.frame});
  if (found != frames_.end()) found->second->film.checkpointed(checkpoint);
}

void Films::hold(JobId job, std::int32_t frame, bool held) {
  const auto found = frames_.find({job, frame});
  if (found != frames_.end()) found->second->holds += held ? 1 : -1;
}

void Films::forget(JobId job, std::int32_t frame) {
  const auto found = frames_.find({job, frame});
  if (found == frames_.end()) return;
  found->second->gone = true;
  memory_ -= found->second->film.memory();
  found->second->changed.notify();
  frames_.erase(found);
}

void Films::forget(JobId job) {
  for (const std::int32_t frame : frames(job)) forget(job, frame);
}

}  // namespace tessera::server
