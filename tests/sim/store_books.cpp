#include "tests/sim/store_books.hpp"

#include <fmt/format.h>

#include <cstring>

#include "common/base/error.hpp"
#include "server/coordinator/frame_file.hpp"
#include "tests/sim/ledger.hpp"

namespace tessera::sim {

namespace {

/// `what` gives the words for it.
template <class Value, class What>
void hold(Kept<Value>& kept, const Value& found, bool started, const What& what) {
  require(started ? kept.may_be(found) : found == kept.value(), [&] {
    return fmt::format("{} is what it was{}: {} ≠ {}", what(), started ? ", or was to be" : "",
                       found, kept.value());
  });
  if (started) kept.acknowledge(found);
}

}  // namespace

std::vector<std::byte> bytes_of(const TaskId& task, std::uint64_t number) {
  Random random(number * 0x9e3779b97f4a7c15ULL + task.tile);
  std::vector<std::byte> bytes(
      static_cast<std::size_t>(random.chance(0.02) ? random.whole(0, 9000) : random.whole(0, 400)));
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random.next());
  return bytes;
}

server::ResultInfo info_of(JobId job, const TaskId& task, std::uint64_t number) {
  server::ResultInfo info;
  info.job = job;
  info.task = task;
  info.lease = {1, number};
  info.identity = fmt::format("worker {}", number % 7);
  info.samples = static_cast<std::int64_t>(number);
  return info;
}

std::filesystem::path frame_file(std::int32_t frame) {
  return server::frame_path(data_folder, static_cast<JobId>(frame % 3), frame);
}

void Books::check(const server::Store& store, SimDisk& disk, bool started) {
  if (started) {
    require(store.epoch() > epoch, "each start has an epoch of its own");
    epoch = store.epoch();
    require(!key || *key == store.grant_key(), "the folder keeps its key");
    key = store.grant_key();
  }
  check_jobs(store, started);
  check_frames(disk, started);
  require(store.journal_bytes() == disk.bytes_in(data_folder / "journal", ".segment"),
          fmt::format("the journal's bytes are counted: {} of {}", store.journal_bytes(),
                      disk.bytes_in(data_folder / "journal", ".segment")));
}

void Books::check_jobs(const server::Store& store, bool started) {
  std::set<JobId> found;
  for (const server::JobRecord& record : store.list_jobs()) {
    found.insert(record.id);
    if (!jobs.contains(record.id)) {
      require(started && doubtful_new.contains(record.spec.name),
              fmt::format("job {} ({}) was put by somebody", record.id, record.spec.name));
      jobs[record.id].state.acknowledge(record.state);
    }
    hold(jobs[record.id].state, record.state, started,
         [&] { return fmt::format("job {}'s state", record.id); });
  }
  if (started) doubtful_new.clear();
  for (auto& [id, truth] : jobs) {
    require(found.contains(id), fmt::format("job {}, which was acknowledged, is there", id));
    check_results(store, id, truth, started);
  }
}

void Books::check_results(const server::Store& store, JobId job, JobTruth& truth, bool started) {
  std::map<TaskId, std::uint64_t> found;
  store.results_of(job, [&](const server::IndexedResult& result) {
    const auto number = static_cast<std::uint64_t>(result.samples);
    require(found.emplace(result.task, number).second,
            [&] { return fmt::format("job {} {} is there once", job, text_of(result.task)); });
    const server::StoredResult stored = store.read_result(result.place);
    require(stored.info == info_of(job, result.task, number) &&
                stored.exr == bytes_of(result.task, number),
            [&] { return fmt::format("job {} {} has its bytes", job, text_of(result.task)); });
  });
  for (const auto& entry : found) {
    const TaskId& task = entry.first;
    require(truth.results.contains(task),
            [&] { return fmt::format("job {} {} was appended by somebody", job, text_of(task)); });
  }
  for (auto& [task, kept] : truth.results) {
    const auto at = found.find(task);
    hold(kept, at == found.end() ? std::uint64_t{0} : at->second, started,
         [&, &place = task] { return fmt::format("job {} {}", job, text_of(place)); });
  }
}

void Books::check_frames(SimDisk& disk, bool started) {
  for (auto& [frame, kept] : frames) {
    std::uint64_t found = 0;
    try {
      const auto file = disk.open(frame_file(frame));
      std::vector<std::byte> bytes(file->size());
      file->read_at(bytes, 0);
      require(bytes.size() >= sizeof found, fmt::format("frame {} is whole", frame));
      std::memcpy(&found, bytes.data(), sizeof found);
      const auto rest = bytes_of({frame, 0, 0}, found);
      require(bytes.size() == sizeof found + rest.size() &&
                  std::memcmp(bytes.data() + sizeof found, rest.data(), rest.size()) == 0,
              fmt::format("frame {} is whole", frame));
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::not_found) throw;
    }
    const std::string what = fmt::format("frame {}'s file", frame);
    require(kept.may_be(found),
            fmt::format("{} is what it was, or was to be: {} ≠ {}", what, found, kept.value()));
    // A rename whose sync failed may be undone by a power cut, until a start has settled it.
    if (started) kept.acknowledge(found);
  }
}

}  // namespace tessera::sim
