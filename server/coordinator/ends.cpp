#include <fmt/format.h>

#include <algorithm>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "server/coordinator/frame_file.hpp"
#include "server/coordinator/impl.hpp"
#include "server/coordinator/retry.hpp"
#include "server/film/film_tile_bytes.hpp"

/// How frames and jobs end: files are written, the end is made durable, and what is not needed any
/// more is let go. What fails is tried again, with pauses that double, for as long as the
/// coordinator runs.
namespace tessera::server {

namespace {

Instant now() { return std::chrono::steady_clock::now(); }

}  // namespace

boost::asio::awaitable<void> CoordinatorImpl::finish_frame(JobId id, std::int32_t frame) {
  const AtWork working = at_work(id);
  // Before the file: a start that finds it must not take it for one of all the samples.
  if (known(id).shortened && !co_await save_surely(id)) co_return;
  if (known(id).shortened_unsaved.contains(frame) && !co_await save_shortened_surely(id, frame))
    co_return;
  Duration wait = retry_first;
  while (!co_await write_frame(id, frame)) {
    co_await crew_.pause(wait);
    wait = longer(wait);
    const Job* job = find(id);
    if (crew_.stopping() || !job || job->ended || job->broken) co_return;
  }
}

boost::asio::awaitable<bool> CoordinatorImpl::write_frame(JobId id, std::int32_t frame) {
  const std::filesystem::path file = frame_path(settings_.data, id, frame);
  const auto plan = known(id).plan;
  const std::uint64_t bytes =
      film_bytes(plan->grid.window().pixels(), *image::layout_of(plan->spec.render.aovs));
  WholeFilm whole;
  while (!(whole.share = whole_films_.take(bytes)) && !crew_.stopping())
    co_await files_changed_.wait();
  if (!whole.share) co_return false;
  // Somebody else may have written it meanwhile.
  if (!films_.find(id, frame)) co_return known(id).files.contains(frame);
  try {
    FilmSnapshot film = co_await films_.snapshot(id, frame);
    whole.pixels = std::make_shared<const FilmSnapshot>(std::move(film));
    const image::Metadata metadata = metadata_for(known(id), frame);
    const std::function<char()> write = [this, film = whole.pixels, metadata, file] {
      write_frame_exr(file, settings_.durable, *film, metadata);
      return char{};
    };
    co_await on<char>(files_, write);
  } catch (const std::exception& error) {
    log::error("job {} frame {}: the picture could not be written: {}", id, frame, error.what());
    known(id).trouble = error.what();
    tell_job(id);
    co_return false;
  }
  known(id).trouble.clear();
  Job& job = known(id);
  job.files.insert(frame);
  films_.forget(id, frame);
  if (!is_end(job.record.state) && !job.broken) {
    // Of a film that has the regular passes and no others its checkpoint is made as it stands.
    if (job.passes_of(frame) > job.plan->passes.regular()) whole.let_go();
    if (whole.pixels) whole.counted = settling_.take(bytes);
    job.unsettled.insert(frame);
    crew_.start("a frame's checkpoint", settle_frame(id, frame, std::move(whole)));
  }
  log::info("job {} frame {}: {}", id, frame, file.string());
  frame_news_.changed(id, frame, now());
  files_changed_.notify();
  wake_in_time();
  co_return true;
}

boost::asio::awaitable<void> CoordinatorImpl::finish_job(JobId id) {
  Job& job = known(id);
  const AtWork working = at_work(id);
  while (job.files.size() < job.plan->spec.frames.count() && !crew_.stopping() && !job.broken)
    co_await files_changed_.wait();
  if (crew_.stopping() || job.broken) co_return;
  const JobRecord end = job.end_record("done", "", now(), unix_millis_now());
  job.end = end;
  if (!co_await save_surely(id)) co_return;
  if (job.broken) co_return;  // it has failed meanwhile
  job.end.reset();
  job.has_ended_as(end);
  job.ended = true;
  log::info("job {} is done after {:.1f} s", id, end.render_seconds);
  let_go(id);
  crew_.start("a done job's results", forget_settled(id));
}

boost::asio::awaitable<void> CoordinatorImpl::abandon_job(JobId id, std::string state,
                                                          std::string error) {
  Job& job = known(id);
  const AtWork working = at_work(id);
  if (job.record.state != state) {
    const JobRecord end = job.end_record(state, error, now(), unix_millis_now());
    job.end = end;
    if (!co_await save_surely(id)) co_return;
    job.end.reset();
    job.has_ended_as(end);
  }
  job.owed.emplace();
  job.ended = true;
  const bool kept = co_await keep_pictures(id);
  let_go(id);
  while (!known(id).checkpointing.empty()) co_await files_changed_.wait();
  collect_soon_ = true;
  co_await settle_what_is_owed(id, kept);
}

boost::asio::awaitable<bool> CoordinatorImpl::keep_pictures(JobId id) {
  const bool extended = !known(id).record.extended_from.empty();
  const std::vector<std::int32_t> frames = films_.frames(id);
  bool kept = true;
  for (const std::int32_t frame : frames) {
    if (crew_.stopping()) co_return false;
    if (extended && !co_await surpasses_its_file(id, frame)) continue;
    kept = co_await write_frame(id, frame) && kept;
  }
  if (!extended) co_return kept;
  const std::function<std::set<std::int32_t>()> look = [this, id] {
    return frames_on_disk(settings_.data, id);
  };
  known(id).files = co_await on<std::set<std::int32_t>>(files_, look);
  co_return kept;
}

boost::asio::awaitable<bool> CoordinatorImpl::surpasses_its_file(JobId id, std::int32_t frame) {
  const FrameFilm* film = films_.find(id, frame);
  if (!film) co_return false;
  const Job& job = known(id);
  const std::int64_t have = film->samples();
  const std::int64_t pixels = job.plan->grid.window().pixels();
  const std::function<std::int64_t()> look = [file = frame_path(settings_.data, id, frame)] {
    return samples_of_file(file);
  };
  const std::int64_t before = co_await on<std::int64_t>(files_, look);
  co_return have > before* pixels;
}

void CoordinatorImpl::let_go(JobId id) {
  tell_frames(frame_news_.forget(id));
  films_.forget(id);
  pictures_.forget(id);
  scheduler_.forget_job(id);
  tell_job(id);
  files_changed_.notify();
}

void CoordinatorImpl::fail_job(JobId id, const std::string& reason) {
  Job* job = find(id);
  if (stopping_ || !job || job->ended || job->broken || is_end(job->record.state)) return;
  // Failed in this run alone, and nothing of it is let go: for the store it is under way, so that
  // the next start tries again.
  job->broken = true;
  job->unreadable = fmt::format(
      "{}; its results are kept: the server tries again when it is started anew", reason);
  log::error("job {} has failed: {}", id, job->unreadable);
  files_changed_.notify();
  if (!job->ending) perform(scheduler_.fail_job(id, job->unreadable, now()));
  tell_job(id);
}

boost::asio::awaitable<bool> CoordinatorImpl::save_surely(JobId id) {
  Duration wait = retry_first;
  while (!crew_.stopping() && find(id)) {
    const std::exception_ptr error = co_await save_or_error(id);
    if (!error) co_return true;
    log::error("job {}: its state could not be kept: {}", id, message_of(error));
    co_await crew_.pause(wait);
    wait = longer(wait);
  }
  co_return false;
}

boost::asio::awaitable<bool> CoordinatorImpl::save_shortened_surely(JobId id, std::int32_t frame) {
  const auto end_of = [&]() -> std::optional<std::int64_t> {
    const auto& ends = known(id).record.shortened_frames;
    const auto end = ends.find(frame);
    return end == ends.end() ? std::nullopt : std::optional(end->second);
  };
  Duration wait = retry_first;
  while (!crew_.stopping() && find(id)) {
    const std::optional<std::int64_t> end = end_of();
    const std::function<void()> put = [this, id, frame, end] {
      if (end) return store_->shorten_frame(id, frame, *end);
      store_->unshorten_frame(id, frame);
    };
    std::exception_ptr error;
    try {
      co_await on_writer(put);
    } catch (const std::exception&) {
      error = std::current_exception();
    }
    if (!error) {
      if (end_of() != end) continue;  // it has ended meanwhile
      known(id).shortened_unsaved.erase(frame);
      co_return true;
    }
    log::error("job {} frame {}: its end could not be kept: {}", id, frame, message_of(error));
    co_await crew_.pause(wait);
    wait = longer(wait);
  }
  co_return false;
}

boost::asio::awaitable<void> CoordinatorImpl::keep_end_of(JobId id, std::int32_t frame) {
  const AtWork working = at_work(id);
  co_await save_shortened_surely(id, frame);
}

void CoordinatorImpl::keep(Job& job) {
  job.unsaved = true;
  if (job.keeping || stopping_) return;
  job.keeping = true;
  crew_.start("a job's record", keep_record(job.record.id));
}

boost::asio::awaitable<void> CoordinatorImpl::keep_record(JobId id) {
  Job& job = known(id);
  const AtWork working = at_work(id);
  // Set anew by what is taken back while this is being kept.
  while (job.unsaved && !crew_.stopping()) {
    job.unsaved = false;
    co_await save_surely(id);
  }
  job.keeping = false;
}

}  // namespace tessera::server
