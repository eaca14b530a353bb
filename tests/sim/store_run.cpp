#include "tests/sim/store_run.hpp"

#include <fmt/format.h>
#include <sqlite3.h>

#include "server/coordinator/frame_file.hpp"
#include "tests/sim/store_calls.hpp"

namespace tessera::sim {

namespace {

constexpr int opens_before_calm = 30;

Point any_point(Random& random) {
  return static_cast<Point>(random.whole(0, static_cast<std::int64_t>(Point::commit) - 1));
}

class StoreRun {
 public:
  StoreRun(std::uint64_t seed, const StoreRunOptions& options)
      : random_(seed),
        disk_(random_.next()),
        options_(options),
        calls_(random_, disk_, options.trace) {
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
    length_ = random_.whole(20, 600);
    // What takes many points gets far only where most kinds of them do not fail.
    Random other(seed ^ 0xf011);
    if (other.chance(0.3)) weather_.only = other.chance(0.6) ? Point::sync : any_point(other);
    if (options.fault_at > 0) {
      weather_ = {};
      length_ = 40;
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
    for (std::int64_t i = 0; i < length_; ++i) {
      one_event();
      if (disk_.dead()) start();
    }
    // What was acknowledged is there in the end, after one more power cut.
    disk_.cut_power();
    start();
  }

  StoreOutcome outcome() {
    StoreOutcome outcome;
    outcome.calls = calls_.calls;
    outcome.lives = lives_;
    return outcome;
  }
  SimDisk& disk() { return disk_; }

 private:
  // ---- lives ----
  /// A new process on what the last one left, as often as it takes.
  void start() {
    ++lives_;
    bool clean = false;
    for (int attempt = 0;; ++attempt) {
      store_.reset();
      if (disk_.dead()) disk_.power_on();
      FaultWeather milder = attempt < opens_before_calm ? weather_ : FaultWeather();
      milder.error /= 10;  // an open has many points, and all of them must go well
      disk_.faults.set(milder);
      const std::uint64_t before = disk_.faults.failures();
      if (!calls_.call("open", [this] { open(); })) continue;
      clean = disk_.faults.failures() == before;
      break;
    }
    disk_.faults.set(weather_);
    calls_.use(store_.get());
    calls_.books.check(*store_, disk_, true);
    if (clean) check_no_surplus(*store_, disk_);
  }
  void open() {
    store_ = server::Store::open(data_folder, settings_);
    for (const auto& [job, what] : store_->damage()) throw Error(ErrorKind::failed, what);
    for (JobId job = 0; job < 3; ++job) server::settle_frames(data_folder, job, disk_);
  }

  void one_event() {
    const std::int64_t drawn = random_.whole(0, 99);
    if (drawn < 91)
      calls_.one_change();
    else if (drawn < 94)
      calls_.books.check(*store_, disk_, false);
    else if (drawn < 95)
      start();
    else if (drawn < 96 && weather_.power > 0)
      disk_.cut_power();
    else if (drawn < 97 && weather_.kill > 0)
      disk_.kill();
  }

  Random random_;
  SimDisk disk_;
  StoreRunOptions options_;
  server::StoreSettings settings_;
  FaultWeather weather_;
  std::int64_t length_ = 0;  // events
  std::uint64_t lives_ = 0;
  std::unique_ptr<server::Store> store_;
  StoreCalls calls_;
};

}  // namespace

std::uint64_t StoreOutcome::fault_events() const {
  std::uint64_t sum = 0;
  for (std::size_t kind = 1; kind < fault_kinds; ++kind) sum += faults.at(kind);
  return sum;
}

StoreOutcome run_store(std::uint64_t seed, const StoreRunOptions& options) {
  StoreRun run(seed, options);
  std::string violation;
  const Faults& faults = run.disk().faults;
  try {
    run.run();
  } catch (const Violation& broken) {
    violation = fmt::format("after point {}: not so: {}", faults.points(), broken.what());
  } catch (const Error& error) {
    violation = fmt::format("after point {}: not to be read: {}", faults.points(), error.what());
  }
  StoreOutcome outcome = run.outcome();
  outcome.violation = violation;
  outcome.points = faults.points();
  outcome.sectors_lost = run.disk().sectors_lost();
  for (std::size_t kind = 0; kind < fault_kinds; ++kind)
    outcome.faults.at(kind) = faults.happened(static_cast<Fault>(kind));
  outcome.trace = outcome.points * 1'000'003 + outcome.fault_events() * 101 + outcome.calls;
  return outcome;
}

}  // namespace tessera::sim
