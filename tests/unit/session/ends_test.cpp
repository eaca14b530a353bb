// What becomes of what a job had that fails or is cancelled.
#include <gmock/gmock.h>

#include <fstream>

#include "server/store/database.hpp"
#include "tests/unit/session/farm.hpp"

namespace tessera::server {
namespace {

using testing::HasSubstr;

class Ends : public testing::Test {
 protected:
  Farm farm;
  JobId id = 0;
  const JobSpec spec = farm.spec(48, 32, 16, 20);  // 6 tiles, 4 passes
  std::set<TaskId> delivered;
  const std::filesystem::path pictures = farm.data / "jobs";

  void restart_with_short_upkeep() {
    farm.run(farm.halt());
    farm.upkeep = std::chrono::milliseconds(20);
    farm.io.reset();
    farm.start();
  }
  [[nodiscard]] std::string state() const { return farm.coordinator->job(id)->view.state; }
  [[nodiscard]] std::int64_t results() const {
    Database database(farm.data / "tessera.db", Database::Mode::read_write);
    return database.integer("SELECT count(*) FROM results");
  }
  /// No picture can be written from here on.
  void block_pictures() const {
    std::filesystem::remove_all(pictures);
    std::ofstream(pictures) << "no folder";
  }
  void unblock_pictures() const { std::filesystem::remove(pictures); }

  /// Nine results are delivered; then the orders that are out are given to `rest`.
  awaitable<void> deliver(ScriptedWorker& worker, std::vector<wire::Assign>& rest) {
    worker.on_assign = [&](const wire::Assign& order) {
      if (delivered.size() == 9) return rest.push_back(order);
      delivered.insert(order.task);
      worker.deliver(order);
    };
    id = co_await farm.coordinator->submit(spec);
    co_await worker.connect(farm);
    co_await worker.work([&] { return worker.accepted == 9; });
  }
  static void fail(ScriptedWorker& worker, const wire::Assign& order) {
    wire::Failed message;
    message.job = order.job;
    message.lease = order.lease;
    message.code = "memory";
    message.reason = "no memory";
    worker.stream().send(message);
  }
  /// Three workers cannot render what is left.
  awaitable<void> fail_the_job() {
    ScriptedWorker first("first", '1'), second("second", '2'), third("third", '3');
    std::vector<wire::Assign> rest;
    co_await deliver(first, rest);
    bool failed = false;
    const std::function<bool()> enough = [&] { return failed; };
    std::vector<std::shared_ptr<bool>> working;
    for (ScriptedWorker* worker : {&first, &second, &third}) {
      worker->on_assign = [worker](const wire::Assign& order) { fail(*worker, order); };
      if (worker != &first) co_await worker->connect(farm);
      working.push_back(farm.go(worker->work(enough)));
    }
    for (const wire::Assign& order : rest) fail(first, order);
    co_await farm.until_state(id, "failed");
    failed = true;
    for (const auto& one : working)
      while (!*one) co_await sleep_for(std::chrono::milliseconds(1));
    for (ScriptedWorker* worker : {&first, &second, &third}) worker->vanish();
  }
  [[nodiscard]] std::optional<std::string> difference_from_what_was_delivered() const {
    const JobPlan plan(spec);
    Film film(plan.grid);
    for (std::uint32_t tile = 0; tile < plan.grid.count(); ++tile)
      for (std::uint32_t pass = 0; delivered.contains({1, tile, pass}); ++pass)
        film.fold(tile, synthetic_tile(plan, {1, tile, pass}));
    return image::difference(
        image::read_exr_file(farm.final_file(id)),
        image::read_exr(image::encode_exr(resolve(film.snapshot()), image::Metadata())));
  }
  awaitable<void> until_results_are_gone() {
    while (results() > 0) co_await sleep_for(std::chrono::milliseconds(5));
  }
  /// That nothing happens takes time to see: a few looks of the upkeep.
  awaitable<void> some_upkeep() { co_await sleep_for(std::chrono::milliseconds(200)); }
};

TEST_F(Ends, FailedJobsPictureIsTriedAgainUntilItIsWrittenAndItsResultsStayTillThen) {
  restart_with_short_upkeep();
  const auto scenario = [&]() -> awaitable<void> {
    block_pictures();
    co_await fail_the_job();
    co_await some_upkeep();
    EXPECT_EQ(results(), 9);
    EXPECT_EQ(state(), "failed");
    EXPECT_THAT(farm.coordinator->job(id)->view.waiting_for, HasSubstr("jobs"));
    std::string said;
    try {
      co_await farm.coordinator->png(id, 1, 0);
    } catch (const Error& error) {
      said = error.what();
    }
    EXPECT_THAT(said, HasSubstr("not written yet"));
    unblock_pictures();
    co_await until_results_are_gone();
    EXPECT_EQ(difference_from_what_was_delivered(), std::nullopt);
    EXPECT_EQ(farm.coordinator->job(id)->view.waiting_for, "");
    co_await farm.coordinator->png(id, 1, 0);
  };
  farm.run(scenario());
}

TEST_F(Ends, FailedJobThatWasKilledBeforeItsPictureHasItAfterTheNextStart) {
  const auto scenario = [&]() -> awaitable<void> {
    block_pictures();
    co_await fail_the_job();
    co_await some_upkeep();
  };
  farm.run(scenario());
  farm.kill();
  unblock_pictures();
  farm.start();
  const auto after = [&]() -> awaitable<void> {
    co_await until_results_are_gone();
    EXPECT_EQ(state(), "failed");
    EXPECT_EQ(difference_from_what_was_delivered(), std::nullopt);
  };
  farm.run(after());
}

TEST_F(Ends, StopBeforeAFailedOrCancelledJobsPictureLeavesItToTheNextStart) {
  ScriptedWorker worker("w");
  std::vector<wire::Assign> rest;
  const auto scenario = [&]() -> awaitable<void> {
    co_await deliver(worker, rest);
    worker.vanish();
    // The picture is begun by a coroutine that finds the coordinator stopping.
    co_await farm.coordinator->cancel(id);
    co_await farm.halt();
  };
  farm.run(scenario());
  farm.io.reset();
  farm.start();
  const auto after = [&]() -> awaitable<void> {
    co_await until_results_are_gone();
    EXPECT_EQ(state(), "cancelled");
    EXPECT_EQ(difference_from_what_was_delivered(), std::nullopt);
  };
  farm.run(after());
}

TEST_F(Ends, FailedJobWhosePictureCannotBeWrittenCanBeRemoved) {
  restart_with_short_upkeep();
  const auto scenario = [&]() -> awaitable<void> {
    block_pictures();
    co_await fail_the_job();
    co_await some_upkeep();
    co_await farm.coordinator->purge(id);
    EXPECT_FALSE(farm.coordinator->job(id));
    EXPECT_EQ(results(), 0);
  };
  farm.run(scenario());
}

TEST_F(Ends, CancelledJobsPictureIsTriedOnceThenItsResultsGo) {
  ScriptedWorker worker("w");
  std::vector<wire::Assign> rest;
  const auto scenario = [&]() -> awaitable<void> {
    block_pictures();
    co_await deliver(worker, rest);
    co_await farm.coordinator->cancel(id);
    co_await until_results_are_gone();
    const auto kind = co_await refusal_of(farm.coordinator->png(id, 1, 0));
    EXPECT_EQ(kind, ErrorKind::not_found) << "it has no picture, not a black one";
    worker.vanish();
  };
  farm.run(scenario());
}

}  // namespace
}  // namespace tessera::server
