// A part of the journal that is lacking costs the jobs that need it, and nothing else.
#include <gmock/gmock.h>

#include "server/store/database.hpp"
#include "server/store/store.hpp"
#include "tests/unit/session/farm.hpp"

namespace tessera::server {
namespace {

using testing::HasSubstr;

class Damage : public testing::Test {
 protected:
  Farm farm;
  JobId hurt = 0, whole = 0;
  const JobSpec spec = farm.spec(48, 32, 16, 20);  // 6 tiles, 4 passes

  [[nodiscard]] std::string state(JobId job) const {
    return farm.coordinator->job(job)->view.state;
  }
  [[nodiscard]] Database database() const {
    return {farm.data / "tessera.db", Database::Mode::read_write};
  }
  /// So many results are delivered, then all are killed.
  void deliver_and_kill(JobId& job, std::size_t results) {
    const auto scenario = [&]() -> awaitable<void> {
      ScriptedWorker worker("w");
      std::size_t delivered = 0;
      worker.on_assign = [&](const wire::Assign& order) {
        if (delivered++ < results) worker.deliver(order);
      };
      job = co_await farm.coordinator->submit(spec);
      co_await worker.connect(farm);
      co_await worker.work([&] { return worker.accepted == results; });
      worker.vanish();
    };
    farm.run(scenario());
    farm.kill();
  }
  awaitable<void> finish(JobId job) {
    ScriptedWorker worker("w");
    co_await worker.connect(farm);
    co_await worker.work([&] { return state(job) == "done"; });
    EXPECT_EQ(difference_from_straight_fold(farm, spec, job), std::nullopt);
    worker.leave();
  }
  [[nodiscard]] static awaitable<std::string> said(awaitable<void> request, ErrorKind kind) {
    try {
      co_await std::move(request);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), kind);
      co_return error.what();
    }
    co_return "nothing was thrown";
  }
};

TEST_F(Damage, SegmentThatIsLackingFailsItsJobByNameAndAllOthersGoOn) {
  deliver_and_kill(hurt, 9);
  const auto segment = farm.data / "journal" / "00000001.segment";
  ASSERT_TRUE(std::filesystem::exists(segment));
  farm.start();
  const auto pause = [&]() -> awaitable<void> { co_await farm.coordinator->pause(hurt); };
  farm.run(pause());
  deliver_and_kill(whole, 9);
  std::filesystem::rename(segment, farm.data / "aside");
  farm.start();
  const auto damaged = [&]() -> awaitable<void> {
    EXPECT_EQ(state(hurt), "failed");
    EXPECT_THAT(farm.coordinator->job(hurt)->view.error, HasSubstr(segment.string()));
    co_await finish(whole);
    const std::string extended =
        co_await said(farm.coordinator->extend(hurt, 100), ErrorKind::conflict);
    EXPECT_THAT(extended, HasSubstr(segment.string()));
    const std::string purged = co_await said(farm.coordinator->purge(hurt), ErrorKind::conflict);
    EXPECT_THAT(purged, HasSubstr("cancel it first"));
  };
  farm.run(damaged());
  farm.kill();
  std::filesystem::rename(farm.data / "aside", segment);
  farm.start();
  const auto mended = [&]() -> awaitable<void> {
    EXPECT_EQ(state(hurt), "paused") << "nothing of it was let go";
    co_await farm.coordinator->resume(hurt);
    co_await finish(hurt);
    EXPECT_EQ(farm.coordinator->job(hurt)->shares.at(0).samples, 48 * 32 * 20);
  };
  farm.run(mended());
}

TEST_F(Damage, DamagedJobThatIsCancelledLetsGoOfWhatItHad) {
  deliver_and_kill(hurt, 9);
  std::filesystem::remove(farm.data / "journal" / "00000001.segment");
  farm.start();
  const auto cancel = [&]() -> awaitable<void> {
    co_await farm.coordinator->cancel(hurt);
    while (database().integer("SELECT count(*) FROM results") > 0)
      co_await sleep_for(std::chrono::milliseconds(5));
    co_await farm.coordinator->purge(hurt);
    co_await farm.halt();
  };
  farm.run(cancel());
  farm.io.reset();
  farm.start();
  EXPECT_TRUE(farm.coordinator->jobs().empty());
}

TEST_F(Damage, DoneJobWhoseCheckpointIsLackingKeepsItsPictureAndIsNotExtended) {
  deliver_and_kill(hurt, 9);
  farm.start();
  const auto end = [&]() -> awaitable<void> {
    co_await finish(hurt);
    while (farm.coordinator->storage().checkpoints == 0)
      co_await sleep_for(std::chrono::milliseconds(5));
    co_await farm.halt();
  };
  farm.run(end());
  farm.io.reset();
  const auto file = farm.data / "checkpoints" / "00000001.checkpoint";
  ASSERT_TRUE(std::filesystem::remove(file));
  farm.start();
  const auto damaged = [&]() -> awaitable<void> {
    EXPECT_EQ(state(hurt), "done");
    EXPECT_EQ(difference_from_straight_fold(farm, spec, hurt), std::nullopt);
    const std::string text =
        co_await said(farm.coordinator->extend(hurt, 100), ErrorKind::conflict);
    EXPECT_THAT(text, HasSubstr(file.string()));
    EXPECT_THAT(text, HasSubstr("with 100 samples"));
    EXPECT_EQ(state(hurt), "done");
    co_await farm.coordinator->purge(hurt);
  };
  farm.run(damaged());
}

TEST_F(Damage, FilmThatCannotBeReadBackFailsItsJobAndTheNextStartTriesAgain) {
  deliver_and_kill(hurt, 9);
  const auto segment = farm.data / "journal" / "00000001.segment";
  std::filesystem::copy(segment, farm.data / "aside");
  {  // as long as it was, and of other bytes
    const auto size = std::filesystem::file_size(segment);
    std::filesystem::resize_file(segment, 16);
    std::filesystem::resize_file(segment, size);
  }
  farm.start();
  const auto damaged = [&]() -> awaitable<void> {
    ScriptedWorker worker("w");
    co_await worker.connect(farm);
    co_await worker.work([&] { return state(hurt) == "failed"; });
    EXPECT_THAT(farm.coordinator->job(hurt)->view.error, HasSubstr(segment.string()));
    const std::string extended =
        co_await said(farm.coordinator->extend(hurt, 100), ErrorKind::conflict);
    EXPECT_THAT(extended, HasSubstr("could not be read back"));
    worker.vanish();
  };
  farm.run(damaged());
  farm.kill();
  std::filesystem::remove(segment);
  std::filesystem::rename(farm.data / "aside", segment);
  farm.start();
  const auto mended = [&]() -> awaitable<void> { co_await finish(hurt); };
  farm.run(mended());
}

}  // namespace
}  // namespace tessera::server
