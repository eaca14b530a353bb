// What the store holds of a job when it refuses some of what it is given.
#include "server/store/database.hpp"
#include "server/store/store.hpp"
#include "tests/unit/session/farm.hpp"

namespace tessera::server {
namespace {

class Records : public testing::Test {
 protected:
  Records() { id = farm_job(); }

  JobId farm_job() {
    JobId made = 0;
    const auto submit = [&]() -> awaitable<void> {
      made = co_await farm.coordinator->submit(farm.spec());
    };
    farm.run(submit());
    return made;
  }
  /// Every record of a job that the store takes is counted; those of this state it refuses.
  void refuse(const std::string& state) {
    database().execute(
        "CREATE TABLE IF NOT EXISTS taken(state TEXT);"
        "CREATE TRIGGER IF NOT EXISTS takes AFTER UPDATE ON jobs BEGIN"
        " INSERT INTO taken VALUES(NEW.state); END;"
        "CREATE TRIGGER refuses BEFORE UPDATE ON jobs WHEN NEW.state = '" +
        state + "' BEGIN SELECT RAISE(ABORT, 'refused by the test'); END;");
  }
  void allow() { database().execute("DROP TRIGGER refuses"); }
  [[nodiscard]] Database database() const {
    return {farm.data / "tessera.db", Database::Mode::read_write};
  }
  [[nodiscard]] std::int64_t taken() const {
    return database().integer("SELECT count(*) FROM taken");
  }
  awaitable<void> until_taken(std::int64_t count) const {
    while (taken() < count) co_await sleep_for(std::chrono::milliseconds(5));
  }
  [[nodiscard]] JobRecord kept() {
    farm.run(farm.halt());
    StoreSettings settings;
    settings.durable = false;
    return Store::open(farm.data, settings)->list_jobs().at(0);
  }

  Farm farm;
  JobId id = 0;
};

TEST_F(Records, ARefusedSaveThatIsTriedAgainDoesNotUndoWhatCameMeanwhile) {
  ScriptedWorker worker("w");
  std::size_t orders = 0;
  worker.on_assign = [&](const wire::Assign&) { ++orders; };
  refuse("rendering");
  const auto scenario = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    co_await worker.work([&] { return orders > 0; });  // its start is refused
    co_await farm.coordinator->pause(id);
    JobChange change;
    change.priority = 7;
    co_await farm.coordinator->change(id, change);
    allow();
    co_await until_taken(3);  // both, and the start
  };
  farm.run(scenario());
  const JobRecord record = kept();
  EXPECT_EQ(record.state, "paused");
  EXPECT_EQ(record.priority, 7);
  EXPECT_NE(record.started, 0);
}

TEST_F(Records, AJobThatEndedIsNotTakenBackByTheSaveOfItsStart) {
  ScriptedWorker worker("w");
  std::size_t orders = 0;
  worker.on_assign = [&](const wire::Assign&) { ++orders; };
  refuse("rendering");
  const auto scenario = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    co_await worker.work([&] { return orders > 0; });
    co_await farm.coordinator->cancel(id);
    allow();
    co_await until_taken(2);
  };
  farm.run(scenario());
  EXPECT_EQ(kept().state, "cancelled");
}

TEST_F(Records, ACancelThatIsRefusedDoesNotHoldUpAnExtension) {
  refuse("cancelled");
  bool refused = false;
  const auto cancel = [&]() -> awaitable<void> {
    try {
      co_await farm.coordinator->cancel(id);
    } catch (const Error&) {
      refused = true;
    }
  };
  ScriptedWorker worker("w");
  const auto scenario = [&]() -> awaitable<void> {
    const auto cancelled = farm.go(cancel());
    co_await sleep_for(Duration::zero());
    co_await farm.coordinator->extend(id, 100);
    EXPECT_TRUE(*cancelled && refused);
    co_await worker.connect(farm);
    co_await worker.work([&] { return farm.coordinator->job(id)->view.state == "done"; });
    JobSpec spec = farm.spec();
    spec.render.samples = 100;
    EXPECT_EQ(difference_from_straight_fold(farm, spec, id), std::nullopt);
  };
  farm.run(scenario());
  EXPECT_EQ(kept().state, "done");
}

TEST_F(Records, WhileTheDiskRefusesResultsAnExtensionIsRefusedAtOnceAndLaterTaken) {
  database().execute(
      "CREATE TRIGGER refuses BEFORE INSERT ON results BEGIN SELECT RAISE(ABORT, 'no'); END");
  ScriptedWorker worker("w");
  const auto scenario = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    co_await worker.work([&] { return !farm.coordinator->trouble().empty(); });
    const auto kind = co_await refusal_of(farm.coordinator->extend(id, 100));
    EXPECT_EQ(kind, ErrorKind::unreachable);
    allow();
    co_await worker.work([&] { return farm.coordinator->trouble().empty(); });
    const auto extended = farm.go(farm.coordinator->extend(id, 100));
    co_await worker.work([&] { return *extended; });
    co_await worker.work([&] { return farm.coordinator->job(id)->view.state == "done"; });
  };
  farm.run(scenario());
  EXPECT_EQ(kept().spec.render.samples, 100);
}

TEST_F(Records, AFilmThatIsWrittenIsNotWrittenAgainBecauseItsCommitIsRefused) {
  database().execute(
      "CREATE TRIGGER refuses BEFORE INSERT ON checkpoints BEGIN SELECT RAISE(ABORT, 'no'); END");
  const auto files = [&] {
    return std::distance(std::filesystem::directory_iterator(farm.data / "checkpoints"), {});
  };
  ScriptedWorker worker("w");
  const auto scenario = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    co_await worker.work([&] { return farm.coordinator->job(id)->view.state == "done"; });
    co_await worker.work([&, looks = 0]() mutable { return ++looks > 25; });  // some tries
    EXPECT_EQ(files(), 1);
    allow();
    while (database().integer("SELECT count(*) FROM checkpoints") == 0)
      co_await sleep_for(std::chrono::milliseconds(5));
    EXPECT_EQ(database().integer("SELECT number FROM checkpoints"), 1);
    EXPECT_EQ(files(), 1);
  };
  farm.run(scenario());
}

TEST_F(Records, ARefusedChangeIsTakenBackAndTheStoreSaysSo) {
  refuse("paused");
  const auto scenario = [&]() -> awaitable<void> {
    bool refused = false;
    try {
      co_await farm.coordinator->pause(id);
    } catch (const Error&) {
      refused = true;
    }
    EXPECT_TRUE(refused);
    EXPECT_EQ(farm.coordinator->job(id)->view.state, "queued");
    co_await until_taken(1);
  };
  farm.run(scenario());
  EXPECT_EQ(kept().state, "queued");
}

}  // namespace
}  // namespace tessera::server
