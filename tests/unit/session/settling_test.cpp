// Films of finished jobs on their way to their checkpoints, and jobs that go on from them.
#include <gmock/gmock.h>

#include <fstream>

#include "server/store/database.hpp"
#include "tests/unit/session/farm.hpp"

namespace tessera::server {
namespace {

using testing::HasSubstr;

class Settling : public testing::Test {
 protected:
  Farm farm;
  JobId id = 0;
  const JobSpec spec = farm.spec(48, 32, 16, 20);  // 6 tiles, 4 passes
  const std::filesystem::path checkpoints = farm.data / "checkpoints";
  const std::filesystem::path segment = farm.data / "journal" / "00000001.segment";

  [[nodiscard]] std::string state() const { return farm.coordinator->job(id)->view.state; }
  [[nodiscard]] std::int64_t results() const {
    Database database(farm.data / "tessera.db", Database::Mode::read_write);
    return database.integer("SELECT count(*) FROM results");
  }
  awaitable<void> until_results_are_gone() {
    while (results() > 0) co_await sleep_for(std::chrono::milliseconds(5));
  }
  void restart_with_patience(Duration patience) {
    farm.run(farm.halt());
    farm.patience = patience;
    farm.io.reset();
    farm.start();
  }
  void block_checkpoints() const {
    std::filesystem::remove_all(checkpoints);
    std::ofstream(checkpoints) << "no folder";
  }
  awaitable<void> finish_without_checkpoint() {
    ScriptedWorker worker("w");
    block_checkpoints();
    id = co_await farm.coordinator->submit(spec);
    co_await worker.connect(farm);
    co_await worker.work([&] { return state() == "done"; });
    worker.vanish();
  }
  void unblock_checkpoints() const {
    std::filesystem::remove(checkpoints);
    std::filesystem::create_directory(checkpoints);
  }
  awaitable<void> finish_extended(std::int64_t samples) {
    ScriptedWorker worker("w");
    std::size_t first_passes = 0;
    worker.on_assign = [&](const wire::Assign& order) {
      if (order.task.pass < 3) ++first_passes;
      worker.deliver(order);
    };
    co_await worker.connect(farm);
    co_await worker.work([&] { return state() == "done"; });
    worker.vanish();
    EXPECT_EQ(first_passes, 0U) << "it went on from what it had";
    JobSpec more = spec;
    more.render.samples = samples;
    EXPECT_EQ(difference_from_straight_fold(farm, more, id), std::nullopt);
  }
};

TEST_F(Settling, ResultsThatCannotBeReadForAWhileAreNotForgotten) {
  farm.run(finish_without_checkpoint());
  farm.kill();
  unblock_checkpoints();
  farm.start();
  // It is there at the start, and cannot be opened when it is to be read.
  std::filesystem::rename(segment, farm.data / "aside");
  std::filesystem::create_symlink(segment, segment);
  const auto scenario = [&]() -> awaitable<void> {
    co_await sleep_for(std::chrono::milliseconds(300));
    EXPECT_GT(results(), 0);
    std::filesystem::remove(segment);
    std::filesystem::rename(farm.data / "aside", segment);
    co_await until_results_are_gone();
    co_await farm.coordinator->extend(id, 100);
    co_await finish_extended(100);
  };
  farm.run(scenario());
}

TEST_F(Settling, JobIsRemovedThoughItsFilmCannotBeKept) {
  const auto scenario = [&]() -> awaitable<void> {
    co_await finish_without_checkpoint();
    co_await farm.coordinator->purge(id);
    EXPECT_FALSE(farm.coordinator->job(id));
    EXPECT_EQ(results(), 0);
  };
  farm.run(scenario());
}

TEST_F(Settling, FilmThatCannotBeKeptDoesNotStayInMemory) {
  JobSpec regular = farm.spec(48, 32, 16, 16);  // kept as it stands
  ScriptedWorker worker("w");
  const auto scenario = [&]() -> awaitable<void> {
    block_checkpoints();
    id = co_await farm.coordinator->submit(regular);
    co_await worker.connect(farm);
    co_await worker.work([&] { return state() == "done"; });
    while (farm.coordinator->storage().films > 0) co_await sleep_for(std::chrono::milliseconds(5));
    EXPECT_GT(results(), 0);
    unblock_checkpoints();
    co_await until_results_are_gone();
    EXPECT_GT(farm.coordinator->storage().checkpoints, 0U);
  };
  farm.run(scenario());
}

TEST_F(Settling, ExtensionThatCannotBeginIsSaidInTimeAndTheJobStaysAsItWas) {
  restart_with_patience(std::chrono::milliseconds(150));
  const auto scenario = [&]() -> awaitable<void> {
    co_await finish_without_checkpoint();
    std::string said;
    try {
      co_await farm.coordinator->extend(id, 100);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::unreachable);
      said = error.what();
    }
    EXPECT_THAT(said, HasSubstr("as it was"));
    EXPECT_EQ(state(), "done");
    EXPECT_EQ(farm.coordinator->job(id)->plan->spec.render.samples, 20);
    EXPECT_EQ(difference_from_straight_fold(farm, spec, id), std::nullopt);
    unblock_checkpoints();
    co_await until_results_are_gone();
    co_await farm.coordinator->extend(id, 100);
    co_await finish_extended(100);
  };
  farm.run(scenario());
}

TEST_F(Settling, JobUnderWayGoesOnIfItsExtensionCannotBegin) {
  restart_with_patience(std::chrono::milliseconds(150));
  JobSpec frames = spec;
  frames.frames = {1, 2, 1};
  ScriptedWorker worker("w");
  std::vector<wire::Assign> held;
  bool refused = false;
  worker.on_assign = [&](const wire::Assign& order) {
    const bool last = order.task == TaskId{2, 0, 3};
    if (!last || refused) return worker.deliver(order);
    held.push_back(order);
  };
  const auto scenario = [&]() -> awaitable<void> {
    block_checkpoints();
    id = co_await farm.coordinator->submit(frames);
    co_await worker.connect(farm);
    co_await worker.work(
        [&] { return farm.coordinator->job(id)->frames_done == 1 && !held.empty(); });
    const auto kind = co_await refusal_of(farm.coordinator->extend(id, 100));
    EXPECT_EQ(kind, ErrorKind::unreachable);
    refused = true;
    for (const wire::Assign& order : held) worker.deliver(order);
    co_await worker.work([&] { return state() == "done"; });
    EXPECT_EQ(worker.revoked + worker.stale, 0U) << "no order was taken back";
    for (const int frame : {1, 2})
      EXPECT_EQ(difference_from_straight_fold(farm, frames, id, frame), std::nullopt);
  };
  farm.run(scenario());
}

TEST_F(Settling, DoneJobWhoseCheckpointIsDamagedIsNotExtendedAndStaysAsItIs) {
  ScriptedWorker worker("w");
  const auto scenario = [&]() -> awaitable<void> {
    id = co_await farm.coordinator->submit(spec);
    co_await worker.connect(farm);
    co_await worker.work([&] { return state() == "done"; });
    worker.vanish();
    co_await until_results_are_gone();
    const auto file = checkpoints / "00000001.checkpoint";
    const auto at = static_cast<std::streamoff>(std::filesystem::file_size(file) / 2);
    std::fstream bytes(file, std::ios::in | std::ios::out | std::ios::binary);
    bytes.seekg(at);
    const char before = static_cast<char>(bytes.get());
    bytes.seekp(at).put(static_cast<char>(before ^ 1)).flush();
    std::string said;
    try {
      co_await farm.coordinator->extend(id, 100);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::conflict);
      said = error.what();
    }
    EXPECT_THAT(said, HasSubstr(file.string()));
    EXPECT_EQ(state(), "done");
    EXPECT_EQ(difference_from_straight_fold(farm, spec, id), std::nullopt);
    bytes.seekp(at).put(before).flush();
    co_await farm.coordinator->extend(id, 100);
    co_await finish_extended(100);
  };
  farm.run(scenario());
}

}  // namespace
}  // namespace tessera::server
