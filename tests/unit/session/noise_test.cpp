// Frames that end by their noise, in a coordinator whose disk refuses something at the wrong time.
#include "server/store/database.hpp"
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

}  // namespace
}  // namespace tessera::server
