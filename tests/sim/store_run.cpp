#include "tests/sim/store_run.hpp"

#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "common/base/error.hpp"
#include "server/coordinator/frame_file.hpp"
#include "server/store/whole_file.hpp"
#include "tests/sim/ledger.hpp"
#include "tests/sim/store_books.hpp"

namespace tessera::sim {

namespace {

constexpr int opens_before_calm = 30;

class StoreRun {
 public:
  StoreRun(std::uint64_t seed, const StoreRunOptions& options)
      : random_(seed), disk_(random_.next()), options_(options) {
    // The salts of SQLite's log, so that a run is the same twice.
    sqlite3_test_control(SQLITE_TESTCTRL_PRNG_SEED, static_cast<int>(seed & 0x7fffffff) + 1,
                         nullptr);
    settings_.segment_bytes = static_cast<std::uint64_t>(random_.whole(500, 20'000));
    settings_.disk = {std::shared_ptr<void>(), &disk_};
    weather_.error = random_.chance(0.9) ? random_.between(0.01, 0.4) : 0;
    weather_.full = random_.chance(0.5) ? random_.between(0, 0.05) : 0;
    weather_.kill = random_.chance(0.6) ? random_.between(0, 0.003) : 0;
    weather_.power = random_.chance(0.8) ? random_.between(0, 0.004) : 0;
    weather_.spell = random_.chance(0.3) ? 0.1 : 0;
    calls_ = random_.whole(20, 600);
    if (options.fault_at > 0) {
      weather_ = {};
      calls_ = 40;
      disk_.faults.at(options.fault_at, options.fault);
    }
    if (options.trace)
      disk_.watch = [](std::uint64_t number, Point point, Fault fault, const std::string& file) {
        fmt::print("  {}\n", described(number, point, fault, file));
      };
  }
  ~StoreRun() {
    disk_.faults.set({});
    store_.reset();
  }
  StoreRun(const StoreRun&) = delete;
  StoreRun& operator=(const StoreRun&) = delete;

  void run() {
    start();
    for (std::int64_t i = 0; i < calls_; ++i) {
      one_call();
      if (disk_.dead()) start();
    }
    // What was acknowledged is there in the end, after one more power cut.
    disk_.cut_power();
    start();
  }

  StoreOutcome outcome;
  SimDisk& disk() { return disk_; }

 private:
  // ---- lives ----
  /// A new process on what the last one left, as often as it takes.
  void start() {
    ++outcome.lives;
    for (int attempt = 0;; ++attempt) {
      store_.reset();
      if (disk_.dead()) disk_.power_on();
      FaultWeather milder = attempt < opens_before_calm ? weather_ : FaultWeather();
      milder.error /= 10;  // an open has many points, and all of them must go well
      disk_.faults.set(milder);
      if (call("open", [this] { open(); })) break;
    }
    disk_.faults.set(weather_);
    books_.check(*store_, disk_, true);
  }
  void open() {
    store_ = server::Store::open(data_folder, settings_);
    for (JobId job = 0; job < 3; ++job) server::settle_frames(data_folder, job, disk_);
  }

  /// False if it threw. Only where the disk failed it may, and where it did not throw it is done.
  template <class What>
  bool call(const char* name, What what) {
    const std::uint64_t before = disk_.faults.failures();
    ++outcome.calls;
    if (options_.trace) fmt::print("{}\n", name);
    try {
      what();
      return disk_.commit_point();
    } catch (const Error& error) {
      if (options_.trace) fmt::print("  threw {}\n", error.what());
      require(disk_.faults.failures() > before || disk_.dead(),
              fmt::format("{} fails only where the disk does: {}", name, error.what()));
      return false;
    }
  }
  // ---- what is asked of it ----
  void one_call() {
    const std::int64_t drawn = random_.whole(0, 99);
    if (drawn < 70)
      append();
    else if (drawn < 71 || books_.jobs.empty())
      put_job();
    else if (drawn < 80)
      update_job();
    else if (drawn < 84)
      end_job();
    else if (drawn < 91)
      write_frame();
    else if (drawn < 94)
      books_.check(*store_, disk_, false);
    else if (drawn < 95) {
      store_.reset();
      start();
    } else if (drawn < 96 && weather_.power > 0)
      disk_.cut_power();
    else if (drawn < 97 && weather_.kill > 0)
      disk_.kill();
  }

  JobId any_job() {
    if (books_.jobs.empty()) put_job();
    if (books_.jobs.empty()) return 0;
    return std::next(books_.jobs.begin(),
                     random_.whole(0, static_cast<std::int64_t>(books_.jobs.size()) - 1))
        ->first;
  }
  server::JobRecord record(JobId id, const std::string& state) {
    server::JobRecord record;
    record.id = id;
    record.spec.name = fmt::format("job {}", number_);
    record.spec.bundle = digest_of("bundle");
    record.spec.render.width = record.spec.render.height = 16;
    record.state = state;
    return record;
  }

  void put_job() {
    ++number_;
    const server::JobRecord job = record(0, fmt::format("state {}", number_));
    JobId id = 0;
    call("put job", [&] { id = store_->put_job(job); });
    if (id != 0) {
      require(!books_.jobs.contains(id), "a new job has an id of its own");
      books_.jobs[id].state.acknowledge(job.state);
    } else {
      books_.doubtful_new.insert(job.spec.name);
    }
  }
  void update_job() {
    const JobId id = any_job();
    if (id == 0 || disk_.dead()) return;
    ++number_;
    const server::JobRecord job = record(id, fmt::format("state {}", number_));
    bool done = false;
    call("update job", [&] { store_->update_job(job), done = true; });
    auto& kept = books_.jobs[id].state;
    done ? kept.acknowledge(job.state) : kept.doubt(job.state);
  }
  void append() {
    const JobId id = any_job();
    if (id == 0 || disk_.dead()) return;
    const auto count = random_.chance(0.1) ? random_.whole(5, 40) : random_.whole(1, 4);
    std::vector<std::vector<std::byte>> bytes;
    std::vector<server::NewResult> batch;
    bytes.reserve(static_cast<std::size_t>(count));
    for (std::int64_t i = 0; i < count; ++i) {
      const TaskId task{static_cast<std::int32_t>(random_.whole(1, 2)),
                        static_cast<std::uint32_t>(random_.whole(0, 60)), 0};
      if (std::any_of(batch.begin(), batch.end(),
                      [&](const auto& other) { return other.info.task == task; }))
        continue;
      bytes.push_back(bytes_of(task, ++number_));
      batch.push_back({info_of(id, task, number_), fmt::format("name {}", number_ % 5),
                       digest_of("build"), bytes.back()});
    }
    bool done = false;
    call("append", [&] { store_->append_results(batch), done = true; });
    for (const server::NewResult& result : batch) {
      auto& kept = books_.jobs[id].results[result.info.task];
      done ? kept.acknowledge(result.info.lease.number) : kept.doubt(result.info.lease.number);
    }
  }
  void end_job() {
    const JobId id = any_job();
    if (id == 0 || disk_.dead()) return;
    bool done = false;
    call("end job", [&] { store_->end_job(id), done = true; });
    for (auto& [task, kept] : books_.jobs[id].results) done ? kept.acknowledge(0) : kept.doubt(0);
  }
  void write_frame() {
    const auto frame = static_cast<std::int32_t>(random_.whole(1, 9));
    const std::uint64_t number = ++number_;
    const auto bytes = bytes_of({frame, 0, 0}, number);
    bool done = false;
    call("write a frame's file", [&] {
      server::write_whole(disk_, frame_file(frame), true, [&](server::DiskFile& file) {
        file.write_at(std::as_bytes(std::span(&number, 1)), 0);
        file.write_at(bytes, sizeof number);
      });
      done = true;
    });
    auto& kept = books_.frames[frame];
    done ? kept.acknowledge(number) : kept.doubt(number);
  }

  Random random_;
  SimDisk disk_;
  StoreRunOptions options_;
  server::StoreSettings settings_;
  FaultWeather weather_;
  std::int64_t calls_ = 0;
  std::unique_ptr<server::Store> store_;
  Books books_;
  std::uint64_t number_ = 0;
};

}  // namespace

std::uint64_t StoreOutcome::fault_events() const {
  std::uint64_t sum = 0;
  for (std::size_t kind = 1; kind < fault_kinds; ++kind) sum += faults.at(kind);
  return sum;
}

StoreOutcome run_store(std::uint64_t seed, const StoreRunOptions& options) {
  StoreRun run(seed, options);
  try {
    run.run();
  } catch (const Violation& violation) {
    run.outcome.violation =
        fmt::format("after point {}: not so: {}", run.disk().faults.points(), violation.what());
  } catch (const Error& error) {
    run.outcome.violation =
        fmt::format("after point {}: not to be read: {}", run.disk().faults.points(), error.what());
  }
  StoreOutcome outcome = run.outcome;
  outcome.points = run.disk().faults.points();
  outcome.sectors_lost = run.disk().sectors_lost();
  for (std::size_t kind = 0; kind < fault_kinds; ++kind)
    outcome.faults.at(kind) = run.disk().faults.happened(static_cast<Fault>(kind));
  outcome.trace = outcome.points * 1'000'003 + outcome.fault_events() * 101 + outcome.calls;
  return outcome;
}

}  // namespace tessera::sim
