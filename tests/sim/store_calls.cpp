#include "tests/sim/store_calls.hpp"

#include <algorithm>
#include <utility>

#include "server/store/whole_file.hpp"

namespace tessera::sim {

namespace {

constexpr std::int32_t frames_most = 2;

}  // namespace

StoreCalls::StoreCalls(Random& random, SimDisk& disk, bool trace)
    : random_(random),
      disk_(disk),
      trace_(trace),
      tiles_(static_cast<std::uint32_t>(random.whole(2, 40))) {}

void StoreCalls::one_change() {
  using Call = void (StoreCalls::*)();
  // Each with its share of all.
  static constexpr std::pair<int, Call> table[] = {
      {60, &StoreCalls::append},        {10, &StoreCalls::checkpoint},
      {9, &StoreCalls::update_job},     {7, &StoreCalls::write_frame},
      {3, &StoreCalls::end_job},        {3, &StoreCalls::extend_job},
      {2, &StoreCalls::add_failures},   {2, &StoreCalls::put_job},
      {1, &StoreCalls::forget_results}, {1, &StoreCalls::forget_job},
      {1, &StoreCalls::skip_jobs},      {2, &StoreCalls::shorten_frame}};
  int shares = 0;
  for (const auto& [share, call] : table) shares += share;
  auto drawn = random_.whole(0, shares - 1);
  for (const auto& [share, call] : table) {
    if (drawn < share) {
      (this->*call)();
      return;
    }
    drawn -= share;
  }
}

// ---- jobs ----

JobId StoreCalls::any_job() {
  std::vector<JobId> there;
  for (int tries = 0; tries < 2 && there.empty(); ++tries) {
    for (const auto& [id, kept] : books.jobs)
      if (!kept.value().state.empty()) there.push_back(id);
    if (there.empty() && tries == 0) put_job();
  }
  if (there.empty() || disk_.dead()) return 0;
  return there[static_cast<std::size_t>(
      random_.whole(0, static_cast<std::int64_t>(there.size()) - 1))];
}

server::JobRecord StoreCalls::record(JobId id) {
  ++number_;
  server::JobRecord record;
  record.id = id;
  record.spec.name = fmt::format("job {}", number_);
  record.spec.bundle = digest_of("bundle");
  record.spec.render.width = record.spec.render.height = 16;
  record.state = fmt::format("state {}", number_);
  return record;
}

template <class What>
void StoreCalls::change_job(const char* name, JobId id, const What& what,
                            const Kept<JobTruth>::Change& change) {
  if (id == 0) return;
  bool done = false;
  call(name, [&] { what(), done = true; });
  books.jobs[id].tell(change, done);
}

void StoreCalls::put_job() {
  const server::JobRecord job = record(0);
  JobId id = 0;
  call("put job", [&] { id = store_->put_job(job); });
  if (id == 0) {
    books.doubtful_new.insert(job.spec.name);
    return;
  }
  require(!books.jobs.contains(id) && id > books.numbered, "a new job has a number of its own");
  books.jobs[id].acknowledge([&](JobTruth& truth) { truth.state = job.state; });
}

void StoreCalls::update_job() {
  const JobId id = any_job();
  const server::JobRecord job = record(id);
  change_job(
      "update job", id, [&] { store_->update_job(job); },
      [state = job.state](JobTruth& truth) { truth.state = state; });
}

void StoreCalls::shorten_frame() {
  const JobId id = any_job();
  const auto frame = static_cast<std::int32_t>(random_.whole(1, frames_most));
  const auto samples = static_cast<std::int64_t>(++number_);
  change_job(
      "shorten frame", id, [&] { store_->shorten_frame(id, frame, samples); },
      [frame, samples](JobTruth& truth) { truth.shortened[frame] = samples; });
}

void StoreCalls::extend_job() {
  const JobId id = any_job();
  if (id == 0) return;
  // Results that are folded into checkpoints are the job's in any plan.
  auto passes = static_cast<std::uint32_t>(random_.whole(0, 3));
  for (const auto& [frame, film] : books.jobs[id].value().checkpoints)
    for (const auto& [tile, held] : film) passes = std::max(passes, held.passes);
  const server::JobRecord job = record(id);
  change_job(
      "extend job", id, [&] { store_->extend_job(job, passes); },
      [state = job.state, passes](JobTruth& truth) {
        truth.state = state;
        truth.shortened.clear();
        std::erase_if(truth.results, [&](const auto& kept) { return kept.first.pass >= passes; });
      });
}

void StoreCalls::end_job() {
  const JobId id = any_job();
  change_job(
      "end job", id, [&] { store_->end_job(id); },
      [](JobTruth& truth) {
        truth.results.clear();
        truth.checkpoints.clear();
        truth.tallies.clear();
      });
}

void StoreCalls::forget_results() {
  const JobId id = any_job();
  change_job(
      "forget results", id, [&] { store_->forget_results(id); },
      [](JobTruth& truth) { truth.results.clear(); });
}

void StoreCalls::forget_job() {
  const JobId id = any_job();
  change_job(
      "forget job", id, [&] { store_->forget_job(id); }, [](JobTruth& truth) { truth = {}; });
}

void StoreCalls::skip_jobs() {
  const JobId last = books.jobs.empty() ? 0 : books.jobs.rbegin()->first;
  const JobId skipped = last + static_cast<JobId>(random_.whole(0, 3));
  bool done = false;
  call("skip jobs", [&] { store_->skip_jobs(skipped), done = true; });
  if (done) books.numbered = std::max(books.numbered, skipped);
}

void StoreCalls::add_failures() {
  const JobId id = any_job();
  std::vector<server::FailureRecord> failures(static_cast<std::size_t>(random_.whole(1, 60)));
  for (server::FailureRecord& failure : failures) failure.reason = fmt::format("{}", ++number_);
  change_job(
      "add failures", id, [&] { store_->add_failures(id, failures); },
      [failures](JobTruth& truth) {
        for (const auto& failure : failures)
          truth.failures.insert(truth.failures.begin(), failure.reason);
        if (truth.failures.size() > server::Store::failures_kept)
          truth.failures.resize(server::Store::failures_kept);
      });
}

// ---- results ----

void StoreCalls::append() {
  const JobId id = any_job();
  if (id == 0) return;
  const auto count = random_.chance(0.1) ? random_.whole(5, 40) : random_.whole(1, 4);
  std::vector<std::vector<std::byte>> bytes;
  std::vector<server::NewResult> batch;
  bytes.reserve(static_cast<std::size_t>(count));
  for (std::int64_t i = 0; i < count; ++i) {
    TaskId task{static_cast<std::int32_t>(random_.whole(1, frames_most)),
                static_cast<std::uint32_t>(random_.whole(0, tiles_ - 1)), 0};
    // What a checkpoint holds is asked for no more.
    task.pass = books.jobs[id].value().kept(task.frame, task.tile) +
                static_cast<std::uint32_t>(random_.whole(0, 2));
    if (std::any_of(batch.begin(), batch.end(),
                    [&](const auto& other) { return other.info.task == task; }))
      continue;
    bytes.push_back(bytes_of(task, ++number_));
    batch.push_back(
        {info_of(id, task, number_), worker_name_of(number_), digest_of("build"), bytes.back()});
  }
  std::map<TaskId, std::uint64_t> told;
  for (const server::NewResult& result : batch) told[result.info.task] = result.info.lease.number;
  change_job(
      "append", id, [&] { store_->append_results(batch); },
      [told](JobTruth& truth) {
        for (const auto& [task, number] : told) truth.results[task] = number;
      });
}

void StoreCalls::checkpoint() {
  const JobId id = any_job();
  if (id == 0) return;
  const auto frame = static_cast<std::int32_t>(random_.whole(1, frames_most));
  const JobTruth::Film film =
      books.jobs[id].value().folded(frame, tiles_, static_cast<std::uint32_t>(random_.whole(1, 3)));
  if (film.empty()) return;
  server::Checkpoint made;
  const bool given_up = random_.chance(0.05);
  const bool written = call("write a checkpoint", [&] {
    const auto writer = store_->begin_checkpoint(id, frame);
    for (const auto& [tile, held] : film)
      writer->append(tile, held.passes, bytes_of(frame, tile, held));
    if (!given_up) made = writer->finish();
  });
  if (!written || given_up || random_.chance(0.02)) return;
  const bool again = random_.chance(0.5);
  change_job(
      "put the checkpoint", id,
      [&] {
        for (int tries = again ? 2 : 1;; --tries) {
          try {
            store_->put_checkpoint(made);
            return;
          } catch (const Error&) {
            if (tries > 1) continue;
            store_->discard_checkpoint(made);
            throw;
          }
        }
      },
      [frame, film](JobTruth& truth) { truth.compact(frame, film); });
}

void StoreCalls::write_frame() {
  const auto frame = static_cast<std::int32_t>(random_.whole(1, 9));
  const std::uint64_t number = ++number_;
  const auto bytes = bytes_of(TaskId{frame, 0, 0}, number);
  bool done = false;
  call("write a frame's file", [&] {
    server::write_whole(disk_, frame_file(frame), true, [&](server::DiskFile& file) {
      file.write_at(std::as_bytes(std::span(&number, 1)), 0);
      file.write_at(bytes, sizeof number);
    });
    done = true;
  });
  books.frames[frame].tell([number](std::uint64_t& value) { value = number; }, done);
}

}  // namespace tessera::sim
