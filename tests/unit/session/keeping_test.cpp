// What is kept, where, and for how long: checkpoints, films beyond memory, blobs, jobs.
#include <gmock/gmock.h>

#include <fstream>

#include "server/film/film_tile_bytes.hpp"
#include "server/store/store.hpp"
#include "tests/unit/session/farm.hpp"

namespace tessera::server {
namespace {

using testing::HasSubstr;

class Keeping : public testing::Test {
 protected:
  Farm farm;
  JobId id = 0;

  void restart() {
    farm.io.reset();
    farm.start();
  }
};

TEST_F(Keeping, JournalOfALongJobIsCompactedWhileItRunsAndAKillLosesNothing) {
  const JobSpec spec = farm.spec(48, 32, 16, 6000);  // 28 passes
  const auto first = [&]() -> awaitable<void> {
    ScriptedWorker worker("w");
    std::size_t delivered = 0;
    worker.on_assign = [&](const wire::Assign& order) {
      if (delivered < 6 * 20) worker.deliver(order);
      ++delivered;
    };
    co_await worker.connect(farm);
    id = co_await farm.coordinator->submit(spec);
    co_await worker.work([&] { return worker.accepted == 6 * 20; });
    while (farm.coordinator->storage().checkpoints == 0)
      co_await sleep_for(std::chrono::milliseconds(5));
    worker.vanish();
  };
  farm.run(first());
  farm.kill();
  {
    StoreSettings settings;
    settings.durable = false;
    const auto store = Store::open(farm.data, settings);
    ASSERT_TRUE(store->checkpoint_of(id, 1));
    std::size_t results = 0;
    store->results_of(id, [&](const IndexedResult&) { ++results; });
    EXPECT_LT(results, 6 * 20) << "what the checkpoint holds is no result any more";
  }
  farm.start();
  const auto second = [&]() -> awaitable<void> {
    EXPECT_GT(farm.coordinator->job(id)->progress, 0.5);
    ScriptedWorker worker("w");
    co_await worker.connect(farm);
    co_await worker.work([&] { return farm.done(id); });
    EXPECT_EQ(worker.accepted, 6U * 8);
    EXPECT_EQ(difference_from_straight_fold(farm, spec, id), std::nullopt);
    EXPECT_EQ(farm.coordinator->job(id)->shares.at(0).samples, 48 * 32 * 6000);
  };
  farm.run(second());
}

TEST_F(Keeping, FilmsBeyondTheirMemoryAreReadBackAndEndWithTheSameBits) {
  farm.run(farm.halt());
  const std::uint64_t film = film_bytes(64 * 64, *image::default_layout());
  farm.film_memory = film * 3 / 2;  // of four films under way one and a half
  restart();
  const JobSpec spec = farm.spec(64, 64, 16, 300);
  std::vector<JobId> ids;
  ScriptedWorker worker("w");
  std::uint64_t most = 0;
  const auto scenario = [&]() -> awaitable<void> {
    for (int i = 0; i < 4; ++i) ids.push_back(co_await farm.coordinator->submit(spec));
    co_await worker.connect(farm);
    co_await worker.work([&] {
      most = std::max(most, farm.coordinator->storage().films);
      return std::all_of(ids.begin(), ids.end(), [&](JobId job) { return farm.done(job); });
    });
    for (const JobId job : ids)
      EXPECT_EQ(difference_from_straight_fold(farm, spec, job), std::nullopt);
    EXPECT_GT(most, 0U);
    EXPECT_LE(most, 2 * film + farm.film_memory / 4)
        << "one whose picture is wanted stays, one on its way to a checkpoint, and what is folded";
  };
  farm.run(scenario());
}

TEST_F(Keeping, JobWhoseFilmIsTooLargeIsRefusedWithTheNumbers) {
  farm.run(farm.halt());
  farm.film_memory = 1000 * 1000;
  restart();
  const auto scenario = [&]() -> awaitable<void> {
    std::string said;
    try {
      co_await farm.coordinator->submit(farm.spec(100, 100, 16, 4));
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::too_large);
      said = error.what();
    }
    EXPECT_THAT(said, HasSubstr("1120000"));
    EXPECT_THAT(said, HasSubstr("1000000"));
    EXPECT_THAT(said, HasSubstr("--film-memory"));
    co_await farm.coordinator->submit(farm.spec(80, 100, 16, 4));
  };
  farm.run(scenario());
}

TEST_F(Keeping, JobsAreForgottenAfterTheirTimeWithAllThatIsTheirs) {
  farm.run(farm.halt());
  farm.keep_jobs = std::chrono::milliseconds(300);
  farm.blob_grace = std::chrono::seconds(1);  // from the upload to the submission
  farm.upkeep = std::chrono::milliseconds(10);
  restart();
  ScriptedWorker worker("w");
  const auto scenario = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    id = co_await farm.coordinator->submit(farm.spec(20, 20, 16, 4));
    co_await worker.work([&] { return !farm.coordinator->job(id) || farm.done(id); });
    co_await worker.work([&] { return !farm.coordinator->job(id).has_value(); });
    while (std::filesystem::exists(farm.data / "jobs" / std::to_string(id)) ||
           farm.coordinator->storage().blobs > 0 || farm.coordinator->storage().checkpoints > 0)
      co_await sleep_for(std::chrono::milliseconds(5));
    co_await farm.halt();
  };
  farm.run(scenario());
  worker.vanish();
  restart();
  EXPECT_TRUE(farm.coordinator->jobs().empty());
}

TEST_F(Keeping, StartRemovesNoPicturesButThoseOfForgottenJobsAndGivesNoNewJobTheirNumber) {
  const auto first = [&]() -> awaitable<void> {
    id = co_await farm.coordinator->submit(farm.spec(20, 20, 16, 4));
    co_await farm.halt();
  };
  farm.run(first());
  const auto folder = farm.data / "jobs";
  for (const char* name : {"1.forgotten", "3.forgotten", "41"}) {
    std::filesystem::create_directories(folder / name);
    std::ofstream(folder / name / "frame-0001.txt") << "a picture";
  }
  restart();
  EXPECT_TRUE(std::filesystem::exists(folder / "1" / "frame-0001.txt")) << "its job is known";
  EXPECT_FALSE(std::filesystem::exists(folder / "3.forgotten"));
  EXPECT_TRUE(std::filesystem::exists(folder / "41" / "frame-0001.txt"));
  const auto second = [&]() -> awaitable<void> {
    EXPECT_EQ(co_await farm.coordinator->submit(farm.spec(20, 20, 16, 4)), 42U);
    co_await farm.halt();
  };
  farm.run(second());
}

TEST_F(Keeping, CancelledJobThatHasCheckpointsAloneLosesThemAtTheNextStart) {
  const auto first = [&]() -> awaitable<void> {
    id = co_await farm.coordinator->submit(farm.spec(20, 20, 16, 4));
    co_await farm.halt();
  };
  farm.run(first());
  farm.io.reset();
  {
    // As if the process had died between the end of the job and that of its checkpoints.
    const auto store = Store::open(farm.data, {.durable = false});
    store->put_checkpoint(store->begin_checkpoint(id, 1)->finish());
    JobRecord record = store->list_jobs().at(0);
    record.state = "cancelled";
    store->update_job(record);
  }
  farm.start();
  farm.run(farm.halt());
  farm.io.reset();
  const auto store = Store::open(farm.data, {.durable = false});
  EXPECT_TRUE(store->jobs_with_checkpoints().empty());
}

TEST_F(Keeping, BlobsOfJobsThatAreKeptStayAndThoseOfCancelledOnesGo) {
  farm.run(farm.halt());
  farm.blob_grace = std::chrono::seconds(1);  // from the upload to the submission
  farm.upkeep = std::chrono::milliseconds(5);
  restart();
  const auto scenario = [&]() -> awaitable<void> {
    const JobSpec spec = farm.spec(20, 20, 16, 4);
    id = co_await farm.coordinator->submit(spec);
    co_await sleep_for(std::chrono::seconds(2));
    const assets::BlobStore blobs(farm.data / "blobs", false);
    EXPECT_TRUE(blobs.has(spec.bundle));
    co_await farm.coordinator->cancel(id);
    while (blobs.has(spec.bundle)) co_await sleep_for(std::chrono::milliseconds(5));
  };
  farm.run(scenario());
}

TEST_F(Keeping, BeyondTheDiskLimitNothingNewIsTakenAndWhatIsHereGoesOn) {
  const JobSpec spec = farm.spec(20, 20, 16, 4);
  const auto first = [&]() -> awaitable<void> {
    id = co_await farm.coordinator->submit(spec);
    co_await farm.halt();
  };
  farm.run(first());
  farm.disk_limit = 100;
  farm.upkeep = std::chrono::milliseconds(10);
  restart();
  ScriptedWorker worker("w");
  const auto scenario = [&]() -> awaitable<void> {
    EXPECT_THAT(farm.coordinator->lacks_room(0), HasSubstr("--disk-limit"));
    bool refused = false;
    try {
      co_await farm.coordinator->submit(spec);
    } catch (const Error& error) {
      refused = error.kind() == ErrorKind::no_room;
    }
    EXPECT_TRUE(refused);
    co_await worker.connect(farm);
    co_await worker.work([&] { return farm.done(id); });
    EXPECT_EQ(difference_from_straight_fold(farm, spec, id), std::nullopt);
  };
  farm.run(scenario());
}

}  // namespace
}  // namespace tessera::server
