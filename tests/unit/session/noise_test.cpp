// Frames that end by their noise, in a coordinator whose disk refuses something at the wrong time.
#include <boost/asio/post.hpp>

#include "server/film/film_tile_bytes.hpp"
#include "server/store/database.hpp"
#include "server/store/store.hpp"
#include "tests/unit/session/farm.hpp"

namespace tessera::server {
namespace {

/// Of one tile a frame, so that a frame has whole passes alone. Its passes end at 1, 4, 16, 32, …
class FramesByNoise : public testing::Test {
 protected:
  Farm farm;
  ScriptedWorker worker{"w"};
  JobId id = 0;

  /// Never as low as that, or at the first look.
  [[nodiscard]] JobSpec watched(double threshold, std::int64_t samples, std::int32_t frames) const {
    JobSpec spec = farm.spec(48, 32, 64, samples);
    spec.pass = 16;
    spec.noise_threshold = threshold;
    spec.frames = {1, frames, 1};
    return spec;
  }
  void submit(const JobSpec& spec) {
    const auto scenario = [&]() -> awaitable<void> {
      id = co_await farm.coordinator->submit(spec);
    };
    farm.run(scenario());
  }
  /// What the store is to hold at the next start: so many passes of every frame, and more.
  void halt_and_keep(
      const JobSpec& spec, std::uint32_t passes,
      const std::function<void(Store&)>& more = [](Store&) {}) {
    farm.run(farm.halt());
    farm.io.reset();
    StoreSettings settings;
    settings.durable = false;
    const auto store = Store::open(farm.data, settings);
    const JobPlan plan(spec);
    for (std::uint32_t index = 0; index < spec.frames.count(); ++index)
      for (std::uint32_t pass = 0; pass < passes; ++pass) {
        const TaskId task{spec.frames.number(index), 0, pass};
        const std::vector<std::byte> exr = image::encode_tile(synthetic_tile(plan, task));
        NewResult result;
        result.info.job = id;
        result.info.plan = plan.digest;
        result.info.task = task;
        result.info.identity = std::string(32, 'a');
        result.info.samples = plan.grid.tile(0).pixels() * plan.passes.pass(pass).count;
        result.exr = exr;
        store->append_results(std::span(&result, 1));
      }
    more(*store);
  }
  [[nodiscard]] bool done() const { return farm.done(id); }
  [[nodiscard]] Database database() const {
    return {farm.data / "tessera.db", Database::Mode::read_write};
  }
  void refuse(const std::string& what) {
    database().execute("CREATE TRIGGER refuses BEFORE " + what +
                       " BEGIN SELECT RAISE(ABORT, 'refused by the test'); END");
  }
  void allow() { database().execute("DROP TRIGGER refuses"); }
  /// All that the job has is in a checkpoint.
  [[nodiscard]] bool kept_whole() const {
    return farm.coordinator->storage().checkpoints > 0 &&
           database().integer("SELECT count(*) FROM results") == 0;
  }
  /// One order after another is delivered, and time given for a checkpoint, until that is all.
  awaitable<void> render_until_kept_whole() {
    std::deque<wire::Assign> orders;
    int idle = 0;
    worker.on_assign = [&](const wire::Assign& order) { orders.push_back(order); };
    worker.on_idle = [&] {
      if (orders.empty() || ++idle % 3 != 0 || kept_whole()) return;
      worker.deliver(orders.front());
      orders.pop_front();
    };
    co_await worker.work([&] { return !orders.empty() && kept_whole(); });
    worker.on_assign = nullptr;
    worker.on_idle = nullptr;
  }
};

TEST_F(FramesByNoise, AreLookedAtAfterAnExtensionThatTheDiskRefused) {
  const JobSpec spec = watched(1e-9, 320, 1);
  const auto scenario = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    id = co_await farm.coordinator->submit(spec);
    co_await render_until_kept_whole();
    refuse("UPDATE ON jobs");
    const auto kind = co_await refusal_of(farm.coordinator->extend(id, 1000));
    EXPECT_EQ(kind, ErrorKind::failed);
    allow();
    EXPECT_FALSE(done());
    co_await worker.work([&] { return done(); });
    EXPECT_EQ(difference_from_straight_fold(farm, spec, id), std::nullopt);
  };
  farm.run(scenario());
}

TEST_F(FramesByNoise, AreLookedAtFilmByFilmWhereMemoryIsShortAfterAStart) {
  constexpr std::int32_t frames = 12;
  const JobSpec spec = watched(1e-9, 20, frames);
  const std::uint64_t film = film_bytes(48 * 32, *image::default_layout());
  submit(spec);
  // Every frame has just the passes that its noise is looked at after.
  halt_and_keep(spec, 3);
  farm.film_memory = 2 * film;
  farm.start();
  std::uint64_t most = 0;
  const auto scenario = [&]() -> awaitable<void> {
    // Time enough for the looks; what workers bring comes on top as it is folded.
    const Instant end = std::chrono::steady_clock::now() + std::chrono::milliseconds(300);
    while (std::chrono::steady_clock::now() < end) {
      most = std::max(most, farm.coordinator->storage().films);
      co_await boost::asio::post(*farm.io, boost::asio::use_awaitable);
    }
    co_await worker.connect(farm);
    co_await worker.work([&] { return done(); });
    EXPECT_EQ(worker.accepted, static_cast<std::size_t>(frames)) << "the last pass of each";
    EXPECT_EQ(difference_from_straight_fold(farm, spec, id, frames), std::nullopt);
  };
  farm.run(scenario());
  EXPECT_GT(most, 0U);
  EXPECT_LE(most, farm.film_memory + film) << "one that is looked at stays";
}

TEST_F(FramesByNoise, AreLookedAtThoughTheirJobIsBeingCancelledWhereTheDiskRefusesThat) {
  constexpr std::int32_t frames = 12;
  submit(watched(1e-9, 20, frames));
  halt_and_keep(watched(1e-9, 20, frames), 3);
  refuse("UPDATE ON jobs");
  farm.film_memory = film_bytes(48 * 32, *image::default_layout());  // one look after another
  farm.start();
  Database disk = database();
  disk.execute("BEGIN IMMEDIATE");  // what is to be kept waits
  const auto scenario = [&]() -> awaitable<void> {
    const auto cancelled = farm.go([](Farm& at, JobId job) -> awaitable<void> {
      EXPECT_EQ(co_await refusal_of(at.coordinator->cancel(job)), ErrorKind::failed);
    }(farm, id));
    // Time enough for the looks.
    co_await sleep_for(std::chrono::milliseconds(300));
    EXPECT_FALSE(*cancelled);
    disk.execute("COMMIT");
    while (!*cancelled) co_await sleep_for(std::chrono::milliseconds(5));
    allow();
    co_await worker.connect(farm);
    co_await worker.work([&] { return done(); });
    EXPECT_TRUE(done()) << worker.ended;
  };
  farm.run(scenario());
}

TEST_F(FramesByNoise, HaveNoPictureBeforeTheirEndIsKept) {
  const auto ends = [&] { return database().integer("SELECT count(*) FROM shortened_frames"); };
  refuse("INSERT ON shortened_frames");
  const auto scenario = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    id = co_await farm.coordinator->submit(watched(10, 320, 2));
    co_await worker.work([&] { return worker.accepted == 2 * 3; });
    co_await worker.work([&, looks = 0]() mutable { return ++looks > 25; });  // some tries
    for (const int frame : {1, 2})
      EXPECT_FALSE(std::filesystem::exists(farm.final_file(id, frame)));
    EXPECT_EQ(farm.coordinator->job(id)->frames_done, 0U);
    allow();
    co_await worker.work([&] { return done(); });
    EXPECT_EQ(ends(), 2);
    for (const int frame : {1, 2}) EXPECT_EQ(farm.coordinator->samples(id, frame), 16);
  };
  farm.run(scenario());
}

TEST_F(FramesByNoise, DoNotEndWhereNoPassDoesThoughTheStoreSaysSo) {
  const JobSpec spec = watched(1e-9, 20, 2);
  submit(spec);
  halt_and_keep(spec, 3, [&](Store& store) {
    store.shorten_frame(id, 1, 10);
    store.shorten_frame(id, 2, 20);
  });
  farm.start();
  const auto scenario = [&]() -> awaitable<void> {
    for (const int frame : {1, 2}) EXPECT_EQ(farm.coordinator->samples(id, frame), 20);
    EXPECT_EQ(farm.coordinator->job(id)->frames_shortened, 0U);
    co_await worker.connect(farm);
    co_await worker.work([&] { return done(); });
    EXPECT_EQ(farm.coordinator->job(id)->progress, 1);
    for (const int frame : {1, 2})
      EXPECT_EQ(difference_from_straight_fold(farm, spec, id, frame), std::nullopt);
  };
  farm.run(scenario());
  worker.vanish();
  farm.run(farm.halt());
  farm.io.reset();
  farm.start();
  EXPECT_TRUE(done());
  EXPECT_EQ(farm.coordinator->job(id)->frames_shortened, 0U) << "the store says it no more";
  for (const int frame : {1, 2}) EXPECT_EQ(farm.coordinator->samples(id, frame), 20);
}

TEST_F(FramesByNoise, WhoseEndTheStoreHasWronglyHaveNoPictureBeforeItSaysSo) {
  const JobSpec spec = watched(1e-9, 20, 1);
  submit(spec);
  halt_and_keep(spec, 3, [&](Store& store) { store.shorten_frame(id, 1, 10); });
  refuse("DELETE ON shortened_frames");
  farm.start();
  const auto scenario = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    co_await worker.work([&] { return worker.accepted == 1; });
    co_await worker.work([&, looks = 0]() mutable { return ++looks > 25; });  // some tries
    EXPECT_FALSE(std::filesystem::exists(farm.final_file(id, 1)));
    EXPECT_FALSE(done());
    allow();
    co_await worker.work([&] { return done(); });
    EXPECT_EQ(database().integer("SELECT count(*) FROM shortened_frames"), 0);
  };
  farm.run(scenario());
}

TEST_F(FramesByNoise, GoOnToWhatWasAskedForAndLoseNoResultOfTheLastPass) {
  JobSpec spec = watched(1e-9, 100, 2);
  spec.tile = 16;
  constexpr std::uint32_t last = 8;  // passes end at 1, 4, 16, 32, …, 96, 100
  const auto kept = [&] {
    return database().integer("SELECT count(*) FROM results WHERE frame = 2 AND pass = 8");
  };
  std::size_t delivered = 0, most = 3;
  worker.on_assign = [&](const wire::Assign& order) {
    if (order.task.frame == 2 && order.task.pass == last && delivered++ >= most) return;
    image::TileImage tile = worker.tile_of(order);
    if (order.task.frame == 1) std::ranges::fill(tile.values, 0.0F);  // without noise
    worker.deliver(worker.result_of(order), image::encode_tile(tile));
  };
  const auto scenario = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    id = co_await farm.coordinator->submit(spec);
    co_await worker.work([&] { return delivered > most && kept() == 3; });
    EXPECT_EQ(farm.coordinator->samples(id, 1), 16);
    std::string said;
    try {
      co_await farm.coordinator->extend(id, 99);
    } catch (const Error& error) {
      said = error.what();
    }
    EXPECT_EQ(said,
              "samples: expected no fewer samples than the 100 that job 1 has or is to have, found "
              "99");
    co_await farm.coordinator->extend(id, 100);
    EXPECT_EQ(kept(), 3);
    delivered = 0;
    most = 100;
    co_await worker.work([&] { return done(); });
    EXPECT_EQ(delivered, 3U) << "the other tiles";
    EXPECT_EQ(farm.coordinator->samples(id, 1), 100);
    EXPECT_EQ(difference_from_straight_fold(farm, spec, id, 2), std::nullopt);
  };
  farm.run(scenario());
}

}  // namespace
}  // namespace tessera::server
