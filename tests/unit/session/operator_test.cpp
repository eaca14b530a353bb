// What an operator says is kept: names that are quarantined, jobs that are removed.
#include <gmock/gmock.h>

#include "server/store/database.hpp"
#include "tests/unit/session/farm.hpp"

namespace tessera::server {
namespace {

using testing::HasSubstr;

class Operator : public testing::Test {
 protected:
  Farm farm;
  JobId id = 0;

  [[nodiscard]] Database database() const {
    return {farm.data / "tessera.db", Database::Mode::read_write};
  }
  /// What it throws, by its kind; failed if nothing.
  static awaitable<ErrorKind> fault_of(awaitable<void> request, std::string* said = nullptr) {
    try {
      co_await std::move(request);
    } catch (const Error& error) {
      if (said != nullptr) *said = error.what();
      co_return error.kind();
    }
    ADD_FAILURE() << "nothing was thrown";
    co_return ErrorKind::failed;
  }
};

TEST_F(Operator, QuarantineOutlivesCoordinatorAndWorkerUntilItIsReleased) {
  const auto first = [&]() -> awaitable<void> {
    co_await farm.coordinator->quarantine("machine", "its fan is broken");
    co_await farm.coordinator->quarantine("other", "of no use");
    co_await farm.coordinator->release("other");
    id = co_await farm.coordinator->submit(farm.spec());
  };
  farm.run(first());
  farm.kill();
  farm.start();
  ScriptedWorker worker("machine", '2');
  std::size_t orders = 0;
  worker.on_assign = [&](const wire::Assign& order) {
    ++orders;
    worker.deliver(order);
  };
  const auto second = [&]() -> awaitable<void> {
    const std::vector<Quarantine> kept = farm.coordinator->quarantines();
    if (kept.size() != 1) co_return ADD_FAILURE() << kept.size() << " are kept";
    EXPECT_EQ(kept[0].name, "machine");
    EXPECT_EQ(kept[0].reason, "its fan is broken");
    EXPECT_EQ(kept[0].by, "user");
    EXPECT_GT(kept[0].since, 1'600'000'000'000);
    co_await worker.connect(farm);
    co_await worker.work([&] { return !worker.told.empty(); });
    EXPECT_EQ(farm.coordinator->workers().at(0).state, "quarantined");
    co_await worker.work([&, looks = 0]() mutable { return ++looks > 5; });
    EXPECT_EQ(orders, 0U);
    co_await farm.coordinator->release("machine");
    co_await worker.work([&] { return farm.done(id); });
    EXPECT_EQ(difference_from_straight_fold(farm, farm.spec(), id), std::nullopt);
    worker.vanish();
  };
  farm.run(second());
  farm.kill();
  farm.start();
  EXPECT_TRUE(farm.coordinator->quarantines().empty());
}

TEST_F(Operator, WorkerThatIsBarredByItsOffencesIsSoByItsNameAfterARestart) {
  ScriptedWorker liar("liar", '1');
  liar.on_assign = [&](const wire::Assign& order) {
    wire::Result result = liar.result_of(order);
    result.samples += 1;
    liar.deliver(result, image::encode_tile(liar.tile_of(order)));
  };
  const auto first = [&]() -> awaitable<void> {
    id = co_await farm.coordinator->submit(farm.spec());
    co_await liar.connect(farm);
    co_await liar.work([&] { return !farm.coordinator->quarantines().empty(); });
    while (database().integer("SELECT count(*) FROM quarantines") == 0)
      co_await sleep_for(std::chrono::milliseconds(5));
    liar.vanish();
  };
  farm.run(first());
  farm.kill();
  farm.start();
  ASSERT_EQ(farm.coordinator->quarantines().size(), 1U);
  EXPECT_EQ(farm.coordinator->quarantines()[0].by, "server");
  EXPECT_THAT(farm.coordinator->quarantines()[0].reason, HasSubstr("not what was asked"));
  ScriptedWorker again("liar", '2');
  const auto second = [&]() -> awaitable<void> {
    co_await again.connect(farm);
    co_await again.work([&] { return !again.told.empty(); });
  };
  farm.run(second());
  EXPECT_THAT(again.told.at(0), HasSubstr("quarantined"));
}

TEST_F(Operator, QuarantineThatTheDiskRefusesIsNone) {
  ScriptedWorker worker("w");
  const auto scenario = [&]() -> awaitable<void> {
    database().execute(
        "CREATE TRIGGER refuses BEFORE INSERT ON quarantines BEGIN SELECT RAISE(ABORT, 'no'); END");
    const ErrorKind barred = co_await fault_of(farm.coordinator->quarantine("w", ""));
    EXPECT_EQ(barred, ErrorKind::failed);
    EXPECT_TRUE(farm.coordinator->quarantines().empty());
    co_await worker.connect(farm);
    id = co_await farm.coordinator->submit(farm.spec());
    co_await worker.work([&] { return farm.done(id); });
    database().execute("DROP TRIGGER refuses");
    co_await farm.coordinator->quarantine("w", "");
    database().execute(
        "CREATE TRIGGER refuses BEFORE DELETE ON quarantines BEGIN SELECT RAISE(ABORT, 'no'); END");
    const ErrorKind released = co_await fault_of(farm.coordinator->release("w"));
    EXPECT_EQ(released, ErrorKind::failed);
    EXPECT_EQ(farm.coordinator->quarantines().size(), 1U);
    EXPECT_EQ(farm.coordinator->workers().at(0).state, "quarantined");
  };
  farm.run(scenario());
}

TEST_F(Operator, JobThatHasEndedIsRemovedWithAllThatIsItsAndListenersAreTold) {
  ScriptedWorker worker("w");
  JobId other = 0;
  const auto scenario = [&]() -> awaitable<void> {
    id = co_await farm.coordinator->submit(farm.spec());
    other = co_await farm.coordinator->submit(farm.spec());
    std::string said;
    const ErrorKind early = co_await fault_of(farm.coordinator->purge(id), &said);
    EXPECT_EQ(early, ErrorKind::conflict);
    EXPECT_THAT(said, HasSubstr("cancel it first"));
    co_await worker.connect(farm);
    co_await worker.work([&] { return farm.done(id) && farm.done(other); });
    const auto events = farm.coordinator->subscribe(id);
    co_await farm.coordinator->purge(id);
    EXPECT_FALSE(farm.coordinator->job(id));
    const ErrorKind late = co_await fault_of(farm.coordinator->purge(id));
    EXPECT_EQ(late, ErrorKind::not_found);
    const auto event = co_await events->next(std::chrono::seconds(5));
    if (!event) co_return ADD_FAILURE() << "nothing was told";
    EXPECT_EQ(event->type, "removed");
    EXPECT_EQ(event->job, id);
    EXPECT_THAT(event->data, HasSubstr("\"name\":\"synthetic\""));
    EXPECT_FALSE(std::filesystem::exists(farm.final_file(id).parent_path()));
    for (const char* table : {"jobs WHERE id", "results WHERE job", "checkpoints WHERE job",
                              "tallies WHERE job", "failures WHERE job"})
      EXPECT_EQ(database().integer(fmt::format("SELECT count(*) FROM {} = {}", table, id)), 0);
    EXPECT_EQ(difference_from_straight_fold(farm, farm.spec(), other), std::nullopt);
    worker.vanish();
  };
  farm.run(scenario());
  farm.kill();
  farm.start();
  EXPECT_FALSE(farm.coordinator->job(id));
  EXPECT_TRUE(farm.coordinator->job(other));
}

}  // namespace
}  // namespace tessera::server
