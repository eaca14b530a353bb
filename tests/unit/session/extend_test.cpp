// More samples for a job that is done or under way: the bits of a job that was submitted with them.
#include <gmock/gmock.h>

#include <boost/asio/post.hpp>
#include <fstream>

#include "server/store/store.hpp"
#include "tests/unit/session/farm.hpp"

namespace tessera::server {
namespace {

using testing::HasSubstr;

JobSpec with_samples(JobSpec spec, std::int64_t samples) {
  spec.render.samples = samples;
  return spec;
}

class Extend : public testing::Test {
 protected:
  Farm farm;
  JobId id = 0;
  const JobSpec spec = farm.spec(50, 37, 16, 20);  // passes end at 1, 4, 16, 20

  [[nodiscard]] bool done() const { return farm.coordinator->job(id)->view.state == "done"; }
  /// What the store holds once the coordinator has stopped.
  [[nodiscard]] std::unique_ptr<Store> store() const {
    StoreSettings settings;
    settings.durable = false;
    return Store::open(farm.data, settings);
  }
  void restart() {
    farm.io.reset();
    farm.start();
  }
};

TEST_F(Extend, DoneJobGoesOnWithWhatItHasAndEndsWithTheBitsOfAFreshOne) {
  ScriptedWorker worker("w");
  std::map<std::int64_t, std::set<TaskId>> orders;
  worker.on_assign = [&](const wire::Assign& order) {
    orders[farm.coordinator->job(id)->plan->spec.render.samples].insert(order.task);
    worker.deliver(order);
  };
  const auto scenario = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    id = co_await farm.coordinator->submit(spec);
    co_await worker.work([&] { return done(); });
    EXPECT_EQ(difference_from_straight_fold(farm, spec, id), std::nullopt);
    const std::uint64_t before = farm.coordinator->version(id, 1).value();
    for (const std::int64_t samples : {100, 300}) {
      co_await farm.coordinator->extend(id, samples);
      EXPECT_EQ(farm.coordinator->job(id)->plan->spec.render.samples, samples);
      co_await worker.work([&] { return done(); });
      EXPECT_EQ(difference_from_straight_fold(farm, with_samples(spec, samples), id), std::nullopt);
    }
    EXPECT_GT(farm.coordinator->version(id, 1).value(), before);
    EXPECT_EQ(farm.coordinator->job(id)->extended_from, (std::vector<std::int64_t>{20, 100}));
    co_await farm.halt();
  };
  farm.run(scenario());
  for (const TaskId& task : orders[100]) EXPECT_GE(task.pass, 3U) << "kept from before";
  for (const TaskId& task : orders[300]) EXPECT_GE(task.pass, 4U) << "kept from before";
  EXPECT_TRUE(worker.rejected.empty());
}

TEST_F(Extend, OutlivesKillsOfTheCoordinatorAtAnyOfItsSteps) {
  const auto first = [&]() -> awaitable<void> {
    ScriptedWorker worker("w");
    co_await worker.connect(farm);
    id = co_await farm.coordinator->submit(spec);
    co_await worker.work([&] { return done(); });
    worker.vanish();
  };
  farm.run(first());
  farm.kill();
  farm.start();
  const auto second = [&]() -> awaitable<void> {
    co_await farm.coordinator->extend(id, 100);
    const Picture picture = co_await farm.coordinator->exr(id, 1);
    const image::ExrImage exr = image::read_exr(*picture.bytes);
    EXPECT_EQ(*std::min_element(exr.plane("samples").begin(), exr.plane("samples").end()), 16.0F);
    ScriptedWorker worker("w");
    std::size_t delivered = 0;
    worker.on_assign = [&](const wire::Assign& order) {
      if (delivered++ < 7) worker.deliver(order);
    };
    co_await worker.connect(farm);
    co_await worker.work([&] { return worker.accepted == 7; });
    worker.vanish();
  };
  farm.run(second());
  farm.kill();
  farm.start();
  const auto third = [&]() -> awaitable<void> {
    EXPECT_EQ(farm.coordinator->job(id)->plan->spec.render.samples, 100);
    EXPECT_FALSE(done()) << "the file of 20 samples is not its end";
    ScriptedWorker worker("w");
    co_await worker.connect(farm);
    co_await worker.work([&] { return done(); });
    EXPECT_LT(worker.accepted, 2U * 12U) << "results from before the kill count";
    EXPECT_EQ(difference_from_straight_fold(farm, with_samples(spec, 100), id), std::nullopt);
  };
  farm.run(third());
}

TEST_F(Extend, JobUnderWayGoesOnAndLateResultsOfItsOldPlanAreStaleAndNoFault) {
  ScriptedWorker worker("w");
  std::vector<wire::Result> late;
  std::vector<std::vector<std::byte>> bodies;
  bool extended = false;
  worker.on_assign = [&](const wire::Assign& order) {
    if (extended || order.task.pass < 3) return worker.deliver(order);
    late.push_back(worker.result_of(order));
    bodies.push_back(image::encode_tile(worker.tile_of(order)));
  };
  const auto scenario = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    id = co_await farm.coordinator->submit(spec);
    co_await worker.work([&] { return late.size() >= 2; });
    co_await farm.coordinator->extend(id, 100);
    extended = true;
    for (std::size_t i = 0; i < late.size(); ++i) worker.deliver(late[i], bodies[i]);
    co_await worker.work([&] { return done(); });
    EXPECT_GE(worker.stale, late.size());
    EXPECT_TRUE(worker.rejected.empty());
    EXPECT_EQ(difference_from_straight_fold(farm, with_samples(spec, 100), id), std::nullopt);
  };
  farm.run(scenario());
}

TEST_F(Extend, JobUnderWayIsNeverShownAsCancelledMeanwhile) {
  ScriptedWorker worker("w");
  std::set<std::string> shown;
  bool extended = false;
  const auto look = [&]() -> awaitable<void> {
    while (!extended) {
      shown.insert(farm.coordinator->job(id)->view.state);
      co_await boost::asio::post(*farm.io, boost::asio::use_awaitable);
    }
  };
  const auto scenario = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    id = co_await farm.coordinator->submit(spec);
    co_await worker.work([&] { return worker.accepted > 5; });
    const auto events = farm.coordinator->subscribe(id);
    const auto looked = farm.go(look());
    co_await farm.coordinator->extend(id, 100);
    extended = true;
    co_await worker.work([&] { return done() && *looked; });
    while (const auto event = co_await events->next(std::chrono::milliseconds(300)))
      EXPECT_THAT(event->data, testing::Not(HasSubstr("cancelled")));
  };
  farm.run(scenario());
  EXPECT_EQ(shown, (std::set<std::string>{"rendering"}));
}

TEST_F(Extend, StopWhileAFilmCannotBeKeptLeavesItsResultsToTheNextStart) {
  ScriptedWorker worker("w");
  const std::filesystem::path folder = farm.data / "checkpoints";
  const auto scenario = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    std::filesystem::remove_all(folder);
    std::ofstream(folder) << "no folder";
    id = co_await farm.coordinator->submit(spec);
    co_await worker.work([&] { return done(); });
    co_await sleep_for(std::chrono::milliseconds(50));
    co_await farm.halt();
  };
  farm.run(scenario());
  worker.vanish();
  std::filesystem::remove(folder);
  EXPECT_EQ(store()->jobs_with_results(), std::vector<JobId>{id});
}

TEST_F(Extend, FramesThatWereFinishedGoOnToo) {
  JobSpec frames = with_samples(spec, 5);
  frames.frames = {1, 3, 1};
  ScriptedWorker worker("w");
  const auto scenario = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    id = co_await farm.coordinator->submit(frames);
    co_await worker.work([&] { return farm.coordinator->job(id)->frames_done > 0; });
    co_await farm.coordinator->extend(id, 64);
    co_await worker.work([&] { return done(); });
    for (const int frame : {1, 2, 3})
      EXPECT_EQ(difference_from_straight_fold(farm, with_samples(frames, 64), id, frame),
                std::nullopt);
  };
  farm.run(scenario());
}

TEST_F(Extend, RefusesWhatIsNotMoreAndWhatHasNotGoneWell) {
  ScriptedWorker worker("w");
  const auto refusal = [&](std::int64_t samples) -> awaitable<std::string> {
    std::string said;
    try {
      co_await farm.coordinator->extend(id, samples);
    } catch (const Error& error) {
      said = error.what();
    }
    co_return said;
  };
  const auto scenario = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    id = co_await farm.coordinator->submit(spec);
    co_await worker.work([&] { return done(); });
    EXPECT_THAT(co_await refusal(20), HasSubstr("expected more samples than the 20"));
    EXPECT_THAT(co_await refusal(4), HasSubstr("found 4"));
    EXPECT_THAT(co_await refusal(limits::samples_max + 1), HasSubstr("samples"));
    EXPECT_TRUE(done());
    id = co_await farm.coordinator->submit(spec);
    co_await farm.coordinator->cancel(id);
    EXPECT_THAT(co_await refusal(100), HasSubstr("cancelled"));
    id = 99;
    EXPECT_THAT(co_await refusal(100), HasSubstr("no job 99"));
  };
  farm.run(scenario());
}

TEST_F(Extend, CancelledBeforeItHasMoreThanItHadKeepsThePictureThatItHad) {
  ScriptedWorker worker("w");
  const auto scenario = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    id = co_await farm.coordinator->submit(spec);
    co_await worker.work([&] { return done(); });
    co_await farm.coordinator->extend(id, 100);
    co_await farm.coordinator->cancel(id);
    while (farm.coordinator->job(id)->frames_done == 0)
      co_await sleep_for(std::chrono::milliseconds(5));
    EXPECT_EQ(difference_from_straight_fold(farm, spec, id), std::nullopt);
    const Picture picture = co_await farm.coordinator->exr(id, 1);
    const image::ExrImage exr = image::read_exr(*picture.bytes);
    EXPECT_EQ(*std::min_element(exr.plane("samples").begin(), exr.plane("samples").end()), 20.0F);
  };
  farm.run(scenario());
}

TEST_F(Extend, NothingOfADoneJobStaysInTheJournalAndItsFilmDoes) {
  ScriptedWorker worker("w");
  const auto scenario = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    id = co_await farm.coordinator->submit(spec);
    co_await worker.work([&] { return done(); });
    co_await farm.halt();
  };
  farm.run(scenario());
  worker.vanish();
  restart();  // what was not done yet is done now
  const auto wait = [&]() -> awaitable<void> {
    while (farm.coordinator->storage().journal > 0)
      co_await sleep_for(std::chrono::milliseconds(5));
    co_await farm.halt();
  };
  farm.run(wait());
  const auto kept = store();
  EXPECT_TRUE(kept->jobs_with_results().empty());
  const auto checkpoint = kept->checkpoint_of(id, 1);
  ASSERT_TRUE(checkpoint);
  EXPECT_EQ(checkpoint->tiles.size(), 12U);
  for (const CheckpointTile& tile : checkpoint->tiles) EXPECT_EQ(tile.passes, 3U);
}

TEST_F(Extend, CountsGoOnAndNothingIsCountedTwice) {
  ScriptedWorker worker("w");
  const std::int64_t pixels = 50 * 37;
  const auto scenario = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    id = co_await farm.coordinator->submit(spec);
    co_await worker.work([&] { return done(); });
    co_await farm.coordinator->extend(id, 64);
    EXPECT_EQ(farm.coordinator->job(id)->shares.at(0).samples, 16 * pixels);
    EXPECT_NEAR(farm.coordinator->job(id)->progress, 0.25, 1e-9);
    co_await worker.work([&] { return done(); });
    EXPECT_EQ(farm.coordinator->job(id)->shares.at(0).samples, 64 * pixels);
    EXPECT_EQ(farm.coordinator->job(id)->rays, 2 * 64 * pixels);
    EXPECT_EQ(farm.coordinator->job(id)->progress, 1);
  };
  farm.run(scenario());
}

}  // namespace
}  // namespace tessera::server
