#include "tests/sim/store_books.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <span>

#include "common/base/error.hpp"
#include "server/coordinator/frame_file.hpp"

namespace tessera::sim {

namespace {

std::uint64_t folded_on(std::uint64_t before, std::uint64_t number) {
  Random random(before * 0x9e3779b97f4a7c15ULL + number);
  return random.next();
}

/// The first entry in which the two differ, in words.
template <class Key, class Value, class Name>
std::string first_difference(const std::map<Key, Value>& found, const std::map<Key, Value>& told,
                             const Name& name) {
  const auto [a, b] = std::mismatch(found.begin(), found.end(), told.begin(), told.end());
  if (a == found.end() && b == told.end()) return "";
  if (b == told.end() || (a != found.end() && a->first < b->first))
    return name(a->first) + " is there";
  if (a == found.end() || b->first < a->first) return name(b->first) + " is lacking";
  return name(a->first) + " is another";
}

std::string difference(const JobTruth& found, const JobTruth& told) {
  if (found.state != told.state) return fmt::format("its state is '{}'", found.state);
  const auto task_name = [](const TaskId& task) { return text_of(task); };
  std::string words = first_difference(found.shortened, told.shortened, [](std::int32_t frame) {
    return fmt::format("the end of frame {}", frame);
  });
  if (!words.empty()) return words;
  words = first_difference(found.results, told.results, task_name);
  if (!words.empty()) return words;
  words = first_difference(found.checkpoints, told.checkpoints, [](std::int32_t frame) {
    return fmt::format("the checkpoint of frame {}", frame);
  });
  if (!words.empty()) return words;
  words = first_difference(found.tallies, told.tallies,
                           [](const std::string& name) { return "what is counted for " + name; });
  if (!words.empty()) return words;
  return fmt::format("{} failures, the newest '{}'", found.failures.size(),
                     found.failures.empty() ? "" : found.failures.front());
}

/// All that the store says of the job, each byte of it read.
JobTruth truth_of(const server::Store& store, JobId job, const server::JobRecord& record) {
  JobTruth truth;
  truth.state = record.state;
  truth.shortened = record.shortened_frames;
  store.results_of(job, [&](const server::IndexedResult& result) {
    const auto number = static_cast<std::uint64_t>(result.samples);
    const bool fresh = truth.results.emplace(result.task, number).second;
    require(fresh,
            [&] { return fmt::format("job {} {} is there once", job, text_of(result.task)); });
    const server::StoredResult stored = store.read_result(result.place);
    require(stored.info == info_of(job, result.task, number) &&
                stored.exr == bytes_of(result.task, number),
            [&] { return fmt::format("job {} {} has its bytes", job, text_of(result.task)); });
  });
  for (const server::Checkpoint& checkpoint : store.checkpoints_of(job)) {
    for (const server::CheckpointTile& tile : checkpoint.tiles) {
      const auto what = [&] {
        return fmt::format("job {}'s checkpoint of frame {} has tile {} whole", job,
                           checkpoint.frame, tile.tile);
      };
      JobTruth::Tile held{tile.passes, 0};
      const auto bytes = store.read_checkpoint({checkpoint.number, tile.offset, tile.length});
      require(bytes.size() >= sizeof held.folded, what);
      std::memcpy(&held.folded, bytes.data(), sizeof held.folded);
      require(bytes == bytes_of(checkpoint.frame, tile.tile, held), what);
      truth.checkpoints[checkpoint.frame][tile.tile] = held;
    }
  }
  for (const server::Tally& tally : store.tallies_of(job))
    truth.tallies[tally.worker_name] += tally.samples;
  for (const server::FailureRecord& failure : store.failures(job))
    truth.failures.push_back(failure.reason);
  return truth;
}

}  // namespace

// ---- a job ----

std::uint32_t JobTruth::kept(std::int32_t frame, std::uint32_t tile) const {
  const auto film = checkpoints.find(frame);
  if (film == checkpoints.end()) return 0;
  const auto held = film->second.find(tile);
  return held == film->second.end() ? 0 : held->second.passes;
}

JobTruth::Film JobTruth::folded(std::int32_t frame, std::uint32_t tiles, std::uint32_t most) const {
  const auto before = checkpoints.find(frame);
  Film film = before == checkpoints.end() ? Film() : before->second;
  for (std::uint32_t tile = 0; tile < tiles; ++tile) {
    Tile sums = film.contains(tile) ? film[tile] : Tile();
    for (std::uint32_t i = 0; i < most; ++i) {
      const auto next = results.find({frame, tile, sums.passes});
      if (next == results.end()) break;
      sums = {sums.passes + 1, folded_on(sums.folded, next->second)};
    }
    if (sums.passes > 0) film[tile] = sums;
  }
  return film;
}

void JobTruth::compact(std::int32_t frame, const Film& film) {
  checkpoints[frame] = film;
  std::erase_if(results, [&](const auto& result) {
    const TaskId& task = result.first;
    if (task.frame != frame || task.pass >= kept(frame, task.tile)) return false;
    tallies[worker_name_of(result.second)] += static_cast<std::int64_t>(result.second);
    return true;
  });
}

// ---- what the bytes are ----

std::vector<std::byte> bytes_of(const TaskId& task, std::uint64_t number) {
  Random random(number * 0x9e3779b97f4a7c15ULL + task.tile);
  std::vector<std::byte> bytes(
      static_cast<std::size_t>(random.chance(0.02) ? random.whole(0, 9000) : random.whole(0, 400)));
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random.next());
  return bytes;
}

std::vector<std::byte> bytes_of(std::int32_t frame, std::uint32_t tile,
                                const JobTruth::Tile& held) {
  std::vector<std::byte> bytes(sizeof held.folded);
  std::memcpy(bytes.data(), &held.folded, sizeof held.folded);
  const auto rest = bytes_of(TaskId{frame, tile, held.passes}, held.folded);
  bytes.insert(bytes.end(), rest.begin(), rest.end());
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

std::string worker_name_of(std::uint64_t number) { return fmt::format("name {}", number % 5); }

std::filesystem::path frame_file(std::int32_t frame) {
  return server::frame_path(data_folder, static_cast<JobId>(frame % 3), frame);
}

// ---- what the store is held to ----

void Books::check(const server::Store& store, SimDisk& disk, bool started) {
  if (started) {
    require(store.epoch() > epoch, "each start has an epoch of its own");
    epoch = store.epoch();
    require(!key || *key == store.grant_key(), "the folder keeps its key");
    key = store.grant_key();
  }
  check_jobs(store, started);
  check_frames(disk, started);
  const auto counted = [&](const char* folder, const char* suffix, std::uint64_t bytes) {
    const std::uint64_t present = disk.bytes_in(data_folder / folder, suffix);
    require(bytes == present, [&] {
      return fmt::format("bytes in {} are counted: {} of {}", folder, bytes, present);
    });
  };
  counted("journal", ".segment", store.journal_bytes());
  counted("checkpoints", ".checkpoint", store.checkpoint_bytes());
}

void Books::check_jobs(const server::Store& store, bool started) {
  std::map<JobId, server::JobRecord> records;
  for (const server::JobRecord& record : store.list_jobs()) {
    records[record.id] = record;
    if (jobs.contains(record.id)) continue;
    require(started && doubtful_new.contains(record.spec.name),
            fmt::format("job {} ({}) was put by somebody", record.id, record.spec.name));
    jobs[record.id].acknowledge([&](JobTruth& truth) { truth.state = record.state; });
  }
  if (started) doubtful_new.clear();
  for (auto& [id, kept] : jobs) {
    const auto there = records.find(id);
    server::JobRecord none;
    none.state.clear();
    JobTruth found = truth_of(store, id, there == records.end() ? none : there->second);
    const bool holds = started ? kept.may_be(found) : found == kept.value();
    require(holds, [&, job = id, &told = kept.value()] {
      return fmt::format("job {} is what was acknowledged{}: {}", job,
                         started ? ", or was to be" : "", difference(found, told));
    });
    if (started) kept.found(std::move(found));
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
      const auto rest = bytes_of(TaskId{frame, 0, 0}, found);
      const auto behind = std::span(bytes).subspan(sizeof found);
      require(std::equal(behind.begin(), behind.end(), rest.begin(), rest.end()),
              fmt::format("frame {} is whole", frame));
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::not_found) throw;
    }
    const std::string what = fmt::format("frame {}'s file", frame);
    require(kept.may_be(found),
            fmt::format("{} is what it was, or was to be: {} ≠ {}", what, found, kept.value()));
    // A rename whose sync failed may be undone by a power cut, until a start has settled it.
    if (started) kept.found(found);
  }
}

void check_no_surplus(const server::Store& store, SimDisk& disk) {
  std::set<std::string> known;
  for (const server::JobRecord& record : store.list_jobs())
    for (const server::Checkpoint& checkpoint : store.checkpoints_of(record.id))
      known.insert(fmt::format("{:08}.checkpoint", checkpoint.number));
  for (const std::string& name : disk.names(data_folder / "checkpoints"))
    require(known.contains(name), [&] { return name + " is of a checkpoint that counts"; });
}

}  // namespace tessera::sim
