#include <fmt/format.h>

#include <algorithm>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "server/coordinator/impl.hpp"
#include "server/coordinator/job_content.hpp"
#include "server/coordinator/retry.hpp"
#include "server/film/film_tile_bytes.hpp"
#include "server/store/damaged.hpp"

/// Checkpoints: what has been folded of a frame leaves the journal for a film that is kept whole.
namespace tessera::server {

void CoordinatorImpl::compact_in_time(JobId id, std::int32_t frame) {
  Job* job = find(id);
  const FrameFilm* film = films_.find(id, frame);
  if (!job || !film || stopping_ || job->ending || job->extending) return;
  if (compacting_) return;  // a whole film each: one at a time; the next fold tries again
  if (job->checkpointing.contains(frame)) return;
  const std::size_t whole = film_bytes(job->plan->grid.window().pixels(), *film->layout());
  if (!worth_a_checkpoint(film->journal_bytes(), whole)) return;
  compacting_ = true;
  job->checkpointing.insert(frame);
  crew_.start("a film's checkpoint", compact(id, frame));
}

boost::asio::awaitable<void> CoordinatorImpl::compact(JobId id, std::int32_t frame) {
  const AtWork working = at_work(id);
  films_.hold(id, frame, true);
  bool failed = false;
  try {
    co_await make_checkpoint(id, frame);
  } catch (const std::exception& error) {
    failed = true;
    if (!crew_.stopping())
      log::error("job {} frame {}: its film could not be kept: {}", id, frame, error.what());
  }
  compacting_ = false;
  // The results stay; the next folds try again.
  if (failed && !known(id).ending) co_await crew_.pause(retry_most);
  films_.hold(id, frame, false);
  known(id).checkpointing.erase(frame);
  files_changed_.notify();
}

boost::asio::awaitable<void> CoordinatorImpl::make_checkpoint(JobId id, std::int32_t frame) {
  FilmSnapshot film = co_await films_.snapshot(id, frame);
  const std::uint32_t regular = known(id).plan->passes.regular();
  const bool ends = std::any_of(film.tiles.begin(), film.tiles.end(),
                                [&](const auto& tile) { return tile && tile->passes > regular; });
  if (ends) co_return;  // its last pass has begun: it is kept when the frame is finished
  auto shared = std::make_shared<const FilmSnapshot>(std::move(film));
  const std::function<Checkpoint()> write = [this, id, frame, shared] {
    return write_checkpoint(*store_, id, frame, *shared);
  };
  const Checkpoint made = co_await on<Checkpoint>(checkpoints_, write);
  shared.reset();
  const auto wanted = [&] { return !crew_.stopping() && !known(id).ending; };
  Duration wait = retry_first;
  while (!co_await try_to_put(made)) {
    if (wanted()) co_await crew_.pause(wait);
    if (!wanted()) co_return co_await discard_checkpoint(made);
    wait = longer(wait);
  }
  films_.checkpointed(made);
}

boost::asio::awaitable<bool> CoordinatorImpl::try_to_put(Checkpoint made) {
  try {
    co_await put_checkpoint(made);
  } catch (const std::exception& error) {
    log::error("job {} frame {}: its film, which is written, could not be kept: {}", made.job,
               made.frame, error.what());
    co_return false;
  }
  co_return true;
}

boost::asio::awaitable<void> CoordinatorImpl::discard_checkpoint(Checkpoint made) {
  const std::function<void()> discard = [this, made] { store_->discard_checkpoint(made); };
  try {
    co_await on_writer(discard);
  } catch (const std::exception& error) {
    log::warn("a film that is needed no more is not removed: {}; the next start tries again",
              error.what());
  }
}

boost::asio::awaitable<void> CoordinatorImpl::put_checkpoint(Checkpoint made) {
  const std::function<void()> put = [this, made] { store_->put_checkpoint(made); };
  co_await on_writer(put);
  log::debug("job {} frame {}: a checkpoint of {} bytes", made.job, made.frame, made.bytes);
}

boost::asio::awaitable<void> CoordinatorImpl::settle_frame(JobId id, std::int32_t frame,
                                                           WholeFilm film) {
  const AtWork working = at_work(id);
  // It would be held for long.
  if (known(id).checkpointing.contains(frame)) film.let_go();
  while (known(id).checkpointing.contains(frame)) co_await files_changed_.wait();
  known(id).checkpointing.insert(frame);
  Duration wait = retry_first;
  const auto wanted = [&] {
    const Job& job = known(id);
    return !crew_.stopping() && !job.unwanted &&
           (!is_end(job.record.state) || job.record.state == "done");
  };
  bool settled = false;
  const auto made = std::make_shared<std::optional<Checkpoint>>();
  while (!settled && wanted()) {
    settled = co_await try_to_settle(id, frame, film.pixels, made);
    film.let_go();  // others need the memory; it is read back
    for (Duration left = wait; !settled && left > Duration::zero() && wanted(); left -= retry_first)
      co_await crew_.pause(std::min(left, retry_first));
    wait = longer(wait);
  }
  film.let_go();
  if (!settled && *made) co_await discard_checkpoint(**made);
  Job& job = known(id);
  job.checkpointing.erase(frame);
  // What is cut short is gone on with, from the results: by the next start, or if the job stays.
  if (settled || !(crew_.stopping() || job.unwanted)) job.unsettled.erase(frame);
  files_changed_.notify();
}

boost::asio::awaitable<bool> CoordinatorImpl::try_to_settle(
    JobId id, std::int32_t frame, std::shared_ptr<const FilmSnapshot> film,
    std::shared_ptr<std::optional<Checkpoint>> made) {
  if (*made) co_return co_await try_to_put(**made);
  SettleInput input;
  input.job = id;
  input.frame = frame;
  input.plan = known(id).plan;
  input.passes = known(id).passes_of(frame);
  const std::function<std::optional<Checkpoint>()> make = [this, input, film] {
    if (film) return std::optional(write_checkpoint(*store_, input.job, input.frame, *film));
    return settle(*store_, input, [this] { return stopped_.load(); });
  };
  try {
    *made = co_await on<std::optional<Checkpoint>>(checkpoints_, make);
  } catch (const DamagedError& error) {
    log::error(
        "job {} frame {}: its film is damaged: {}; its picture is written, and if samples "
        "are added all are rendered anew",
        id, frame, error.what());
    co_return true;
  } catch (const std::exception& error) {
    if (!crew_.stopping())
      log::error("job {} frame {}: its film could not be kept: {}", id, frame, error.what());
    co_return false;
  }
  if (!*made) co_return true;
  co_return co_await try_to_put(**made);
}

void CoordinatorImpl::settle_what_is_left(Job& job, const JobContent& content) {
  const std::uint32_t regular = job.plan->passes.regular();
  for (const auto& [task, place] : content.results)
    if (task.pass < regular && job.files.contains(task.frame)) job.unsettled.insert(task.frame);
  settle_all(job);
}

void CoordinatorImpl::settle_all(const Job& job) {
  for (const std::int32_t frame : job.unsettled)
    crew_.start("a frame's checkpoint", settle_frame(job.record.id, frame, {}));
}

boost::asio::awaitable<void> CoordinatorImpl::forget_settled(JobId id) {
  const AtWork working = at_work(id);
  const Job& job = known(id);
  while (!job.unsettled.empty() && !job.unwanted && !crew_.stopping())
    co_await files_changed_.wait();
  if (!job.unsettled.empty()) co_return;       // the next start goes on
  if (!job.ended || job.extending) co_return;  // what is left is part of what it goes on with
  co_await drop_results(id, &Store::forget_results);
}

}  // namespace tessera::server
