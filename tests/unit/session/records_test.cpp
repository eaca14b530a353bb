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
