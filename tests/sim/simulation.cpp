#include "tests/sim/simulation.hpp"

#include <fmt/format.h>
#include <sqlite3.h>

#include <cmath>

#include "common/base/error.hpp"
#include "server/coordinator/frame_file.hpp"
#include "tests/sim/coordinator.hpp"
#include "tests/sim/synthetic.hpp"
#include "tests/sim/worker.hpp"

namespace tessera::sim {

World::World(std::uint64_t seed) : random(seed), drive(random.next()) {
  // The salts of SQLite's log, so that a run is the same twice.
  sqlite3_test_control(SQLITE_TESTCTRL_PRNG_SEED, static_cast<int>(seed & 0x7fffffff) + 1, nullptr);
}
World::~World() = default;

void World::cut(const Link& link, bool notices) {
  link->open = false;
  link->cut_at = events.now();
  events.after(random.between(0, 0.1), [link] { link->worker->disconnected(link); });
  if (!notices) return;
  events.after(random.between(0, 0.1), [this, link] { coordinator->closed(link); });
}

namespace {

constexpr double give_up_seconds = 20000;

Weather draw_weather(Random& random) {
  Weather weather;
  weather.latency_most = random.chance(0.2) ? 0.5 : random.between(0.001, 0.05);
  const auto sometimes = [&](double low, double high) {
    return random.chance(0.6) ? random.between(low, high) : 1e9;
  };
  weather.cut_every = sometimes(0.5, 10);
  weather.crash_every = sometimes(1, 20);
  weather.silence_every = sometimes(2, 20);
  weather.restart_every = sometimes(3, 30);
  weather.leave_every = sometimes(3, 20);
  weather.partition_every = sometimes(4, 30);
  weather.return_chance = random.unit();
  weather.duplicate = random.chance(0.5) ? random.between(0, 0.2) : 0;
  weather.late = random.chance(0.5) ? random.between(0, 0.1) : 0;
  weather.error = random.chance(0.3) ? random.between(0, 0.02) : 0;
  weather.corrupt = random.chance(0.3) ? random.between(0, 0.01) : 0;
  weather.sync_most = random.between(0.002, 0.2);
  weather.fold_most = random.chance(0.2) ? 1.0 : random.between(0.0, 0.05);
  weather.calm_after = random.between(10, 90);
  weather.power = random.unit();
  if (random.chance(0.7)) {
    weather.drive.error = random.chance(0.5) ? random.between(0, 0.03) : 0;
    weather.drive.full = random.chance(0.5) ? random.between(0, 0.01) : 0;
    weather.drive.spell = random.chance(0.5) ? 0.2 : 0;
    weather.drive.kill = random.chance(0.5) ? random.between(0, 0.001) : 0;
    weather.drive.power = random.chance(0.5) ? random.between(0, 0.002) : 0;
  }
  return weather;
}

Rect draw_region(Random& random, const RenderSettings& film) {
  Rect region;
  region.x = static_cast<int>(random.whole(0, film.width - 1));
  region.y = static_cast<int>(random.whole(0, film.height - 1));
  region.width = static_cast<int>(random.whole(1, film.width - region.x));
  region.height = static_cast<int>(random.whole(1, film.height - region.y));
  return region;
}

JobSpec draw_job(Random& random) {
  JobSpec spec;
  spec.name = "job";
  spec.bundle = digest_of("bundle");
  spec.render.width = static_cast<int>(random.whole(1, 12));
  spec.render.height = static_cast<int>(random.whole(1, 4));
  spec.render.samples = random.whole(1, 1500);
  spec.render.seed = random.next() >> 1;
  spec.tile = 1;
  spec.pass = static_cast<int>(random.whole(1, 4) * 32);
  spec.priority = static_cast<int>(random.whole(0, 1));
  if (random.chance(0.2)) spec.max_workers = static_cast<int>(random.whole(1, 4));
  spec.frames = {1, static_cast<std::int32_t>(random.whole(1, 3)), 1};
  if (random.chance(0.2)) {
    spec.time_limit_seconds = random.between(1, 60);
    spec.frames = {1, 1, 1};
  }
  if (random.chance(0.25)) spec.noise_threshold = std::pow(10.0, random.between(-2.5, 0));
  if (random.chance(0.2)) spec.focus = draw_region(random, spec.render);
  return spec;
}

/// One run's script: who comes, and what goes wrong when.
class Script {
 public:
  explicit Script(World& world) : world_(world), power_(world.random.between(20, 400)) {}

  void begin() {
    Random& random = world_.random;
    world_.coordinator = std::make_unique<Coordinator>(world_);
    const auto jobs = random.whole(1, 3);
    for (std::int64_t i = 1; i <= jobs; ++i) {
      const auto id = static_cast<JobId>(i);
      const double when = i == 1 ? 0 : random.between(0, 20);
      ++world_.unanswered;
      world_.events.after(when,
                          [this, spec = draw_job(random)] { world_.coordinator->submit(spec); });
      if (random.chance(0.1))
        world_.events.after(random.between(5, 60), [this, id] { world_.coordinator->cancel(id); });
      if (random.chance(0.2))
        world_.events.after(random.between(5, 60), [this, id] {
          if (world_.disk.jobs.contains(id)) world_.coordinator->pause(id, 7);
        });
    }
    if (random.chance(0.4)) again(random.between(1, 10), [this] { look_closely(); });
    world_.coordinator->start();
    const auto workers = random.whole(1, 10);
    for (std::int64_t i = 0; i < workers; ++i)
      world_.events.after(random.between(0, 10), [this] { add_worker(); });
    const Weather& weather = world_.weather;
    again(weather.cut_every, [this] { cut(); });
    again(weather.crash_every, [this] { crash(); });
    again(weather.silence_every, [this] { silence(); });
    again(weather.leave_every, [this] { leave(); });
    again(weather.partition_every, [this] { partition(); });
    again(weather.restart_every, [this] { restart(); });
    world_.events.after(weather.calm_after, [this] { world_.drive.faults.set({}); });
    world_.events.after(weather.calm_after + 1, [this] {
      for (const char* build : {"build", "build", "other"}) add_worker(build);
    });
    look();
  }

  [[nodiscard]] bool over() const { return world_.coordinator->all_ended(); }

 private:
  void look() {
    world_.coordinator->look_around();
    world_.events.after(1, [this] { look(); });
  }
  void again(double every, const std::function<void()>& what) {
    world_.events.after(every * world_.random.between(0.1, 1.9), [this, every, what] {
      if (world_.calm()) return;
      ++world_.faults;
      what();
      again(every, what);
    });
  }
  void add_worker() { add_worker(world_.random.chance(0.05) ? "other" : "build"); }
  void add_worker(const std::string& build) {
    const double speed = power_ * world_.random.between(1, 10);
    std::string name = fmt::format("worker {}", world_.workers.size());
    if (Worker* const gone = any_worker(false);
        gone != nullptr && world_.random.chance(world_.weather.return_chance))
      name = gone->info().name;
    const bool taken = std::any_of(world_.workers.begin(), world_.workers.end(), [&](auto& other) {
      return other->alive() && other->info().name == name;
    });
    if (taken) name = fmt::format("worker {}", world_.workers.size());
    world_.workers.push_back(std::make_unique<Worker>(world_, name, speed, build));
    world_.workers.back()->start();
  }
  Worker* any_worker(bool living = true) {
    std::vector<Worker*> alive;
    for (const auto& worker : world_.workers) {
      if (worker->alive() == living) alive.push_back(worker.get());
    }
    if (alive.empty()) return nullptr;
    return alive[static_cast<std::size_t>(
        world_.random.whole(0, static_cast<std::int64_t>(alive.size()) - 1))];
  }
  /// A person wants to see a part of some picture, or no part any more.
  void look_closely() {
    const auto& jobs = world_.disk.jobs;
    if (jobs.empty()) return;
    const auto job =
        std::next(jobs.begin(), world_.random.whole(0, static_cast<std::int64_t>(jobs.size()) - 1));
    std::optional<Rect> focus;
    if (world_.random.chance(0.8))
      focus = draw_region(world_.random, job->second.plan->spec.render);
    world_.coordinator->set_focus(job->first, focus);
  }
  void cut() {
    Worker* worker = any_worker();
    if (worker != nullptr && worker->link())
      world_.cut(worker->link(), !world_.random.chance(world_.weather.half_open));
  }
  void crash() {
    if (Worker* worker = any_worker()) worker->crash();
    world_.events.after(world_.random.between(0, 5), [this] { add_worker(); });
  }
  void leave() {
    if (Worker* worker = any_worker()) worker->leave();
    world_.events.after(world_.random.between(0, 5), [this] { add_worker(); });
  }
  void silence() {
    if (Worker* worker = any_worker()) worker->fall_silent(world_.random.between(0.5, 15));
  }
  /// A part of the machines, each way or one way.
  void partition() {
    const double duration = world_.random.between(0.5, 20);
    const double share = world_.random.unit();
    const bool sends = world_.random.chance(0.7), receives = !sends || world_.random.chance(0.6);
    for (const auto& worker : world_.workers) {
      if (world_.random.chance(share)) worker->cut_off(duration, sends, receives);
    }
  }
  void restart() {
    if (world_.coordinator->up())
      world_.coordinator->kill(world_.random.chance(world_.weather.power));
  }

  World& world_;
  double power_;
};

/// After one more power cut, by what is found then.
void audit_disk(World& world) {
  world.drive.faults.set({});
  world.coordinator->kill(true);
  world.coordinator->start();
  audit(world.disk, world.acknowledged, [&](JobId job, std::int32_t frame) {
    const auto file = world.drive.open(server::frame_path(data_folder, job, frame));
    std::vector<std::byte> bytes(file->size());
    file->read_at(bytes, 0);
    return picture_of(bytes, *world.disk.jobs.at(job).plan);
  });
}

}  // namespace

Outcome run(std::uint64_t seed, Bug bug, bool trace) {
  World world(seed);
  world.tracing = trace;
  if (trace)
    world.drive.watch = [&](std::uint64_t number, Point point, Fault fault,
                            const std::string& file) {
      world.tell("{}", described(number, point, fault, file));
    };
  world.bug = bug;
  world.weather = draw_weather(world.random);
  world.segment_bytes = static_cast<std::uint64_t>(world.random.whole(5'000, 100'000));
  world.compact_bytes = static_cast<std::uint64_t>(world.random.whole(500, 60'000));
  world.drive.faults.set(world.weather.drive);
  Script script(world);
  Outcome outcome;
  const auto broken = [&](const std::exception& violation) {
    outcome.violation =
        fmt::format("at {:.3f} s: not so: {}", world.events.seconds_now(), violation.what());
  };
  try {
    script.begin();
    while (!script.over()) {
      require(world.events.step(), "something is left to happen");
      require(world.events.seconds_now() < give_up_seconds,
              "all jobs end in the time that they may take");
    }
    audit_disk(world);
  } catch (const Violation& violation) {
    broken(violation);
  } catch (const Error& error) {
    broken(error);
  }
  outcome.trace = world.trace;
  outcome.events = world.events.count();
  outcome.faults = world.faults + world.drive.faults.failures();
  outcome.decisions = world.decisions;
  outcome.checkpoints = world.checkpoints;
  outcome.shortened = world.shortened;
  outcome.frames_shortened = world.frames_shortened;
  outcome.virtual_seconds = world.events.seconds_now();
  for (const auto& [id, job] : world.disk.jobs)
    outcome.tasks += static_cast<std::uint64_t>(job.plan->tasks());
  return outcome;
}

}  // namespace tessera::sim
