#include "tests/unit/session/farm.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>

namespace tessera::server {
namespace {

using testing::HasSubstr;

TEST(Farm, JobEndsInAFileWithTheBitsOfAStraightFold) {
  Farm farm;
  const JobSpec spec = farm.spec();
  JobId id = 0;
  ScriptedWorker one("one", 'a');
  ScriptedWorker two("two", 'b');
  const auto scenario = [&]() -> awaitable<void> {
    co_await one.connect(farm);
    co_await two.connect(farm);
    EXPECT_EQ(one.welcome.epoch, 1U);
    EXPECT_EQ(one.welcome.blob_url, "http://127.0.0.1:8420");
    id = co_await farm.coordinator->submit(spec);
    bool done = false;
    const std::function<bool()> enough = [&] { return done; };
    const auto first = farm.go(one.work(enough));
    const auto second = farm.go(two.work(enough));
    co_await farm.until_state(id, "done");
    done = true;
    while (!*first || !*second) co_await sleep_for(std::chrono::milliseconds(1));
    const auto status = farm.coordinator->job(id);
    const JobPlan plan(spec);
    EXPECT_EQ(status->progress, 1);
    EXPECT_EQ(status->view.tasks_done, plan.tasks());
    EXPECT_EQ(status->rays, 2LL * 50 * 37 * 20);
    EXPECT_GT(status->started, 0);
    EXPECT_GE(status->finished, status->started);
    std::int64_t shared = 0;
    for (const auto& share : status->shares) shared += share.samples;
    EXPECT_EQ(shared, 50LL * 37 * 20);
    EXPECT_EQ(one.accepted + two.accepted, static_cast<std::size_t>(plan.tasks()));
    EXPECT_TRUE(one.outbox.empty() && two.outbox.empty());
  };
  farm.run(scenario());
  EXPECT_EQ(difference_from_straight_fold(farm, spec, id), std::nullopt);
  const image::ExrImage file = image::read_exr_file(farm.final_file(id));
  EXPECT_EQ(file.metadata.text("tessera.scene"), spec.bundle.hex());
  EXPECT_EQ(file.metadata.text("tessera.samples"), "20");
  EXPECT_NE(file.metadata.text("tessera.build"), "");
  EXPECT_NE(file.metadata.text("tessera.render_seconds"), "");
  EXPECT_NE(file.metadata.text("tessera.cpu_seconds"), "");
}

TEST(Farm, OrderOfArrivalDoesNotChangeTheBits) {
  Farm farm;
  const JobSpec spec = farm.spec(40, 23, 16, 100);
  JobId id = 0;
  ScriptedWorker worker("late");
  std::vector<wire::Assign> orders;
  worker.on_assign = [&](const wire::Assign& order) { orders.push_back(order); };
  // Whatever was handed out comes back last pass first, and only when no more orders come.
  worker.on_idle = [&] {
    std::sort(orders.begin(), orders.end(), [](const auto& a, const auto& b) {
      return std::pair(a.task.pass, a.task.tile) > std::pair(b.task.pass, b.task.tile);
    });
    for (const auto& order : orders) worker.deliver(order);
    orders.clear();
  };
  const auto scenario = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    id = co_await farm.coordinator->submit(spec);
    bool done = false;
    const auto working = farm.go(worker.work([&] { return done; }));
    co_await farm.until_state(id, "done");
    done = true;
    while (!*working) co_await sleep_for(std::chrono::milliseconds(1));
  };
  farm.run(scenario());
  EXPECT_EQ(difference_from_straight_fold(farm, spec, id), std::nullopt);
}

TEST(Farm, KilledInTheMiddleItGoesOnWithTheSameBits) {
  Farm farm;
  const JobSpec spec = farm.spec(70, 50, 16, 30);
  const JobPlan plan(spec);
  JobId id = 0;
  ScriptedWorker worker("steady");
  std::size_t orders = 0;
  worker.on_assign = [&](const wire::Assign& order) {
    // The later half is rendered, but the answer is lost with the coordinator.
    if (++orders < static_cast<std::size_t>(plan.tasks()) / 2) {
      worker.deliver(order);
    } else {
      worker.outbox[order.lease] = {worker.result_of(order),
                                    std::make_shared<const std::vector<std::byte>>(
                                        image::encode_tile(worker.tile_of(order)))};
    }
  };
  const auto before = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    id = co_await farm.coordinator->submit(spec);
    const auto half = static_cast<std::size_t>(plan.tasks()) / 2 - 1;
    co_await worker.work([&] { return worker.accepted >= half && !worker.outbox.empty(); });
    worker.vanish();
  };
  farm.run(before());
  const std::size_t undelivered = worker.outbox.size();
  EXPECT_GT(undelivered, 0U);
  farm.kill();

  const auto reopened = std::chrono::steady_clock::now();
  farm.start();
  EXPECT_LT(std::chrono::steady_clock::now() - reopened, std::chrono::seconds(2));
  worker.on_assign = nullptr;
  const auto after = [&]() -> awaitable<void> {
    const auto status = farm.coordinator->job(id);
    EXPECT_EQ(status->view.state, "rendering");
    EXPECT_GT(status->progress, 0.1);
    EXPECT_GT(status->rays, 0);
    // The picture so far is there before anything new comes.
    const auto version = farm.coordinator->version(id, 1);
    EXPECT_GT(version.value_or(0), 0U);
    const Picture picture = co_await farm.coordinator->exr(id, 1);
    EXPECT_EQ(picture.version, *version);
    const std::size_t accepted = worker.accepted;
    co_await worker.connect(farm);
    EXPECT_EQ(worker.welcome.epoch, 2U);
    bool done = false;
    const auto working = farm.go(worker.work([&] { return done; }));
    co_await farm.until_state(id, "done");
    done = true;
    while (!*working) co_await sleep_for(std::chrono::milliseconds(1));
    EXPECT_EQ(worker.rejected.size(), 0U);
    EXPECT_GE(worker.accepted, accepted + undelivered);  // its outbox was taken in
    EXPECT_EQ(worker.accepted, static_cast<std::size_t>(plan.tasks()));
    EXPECT_GT(farm.coordinator->version(id, 1).value_or(0), *version);
  };
  farm.run(after());
  EXPECT_EQ(difference_from_straight_fold(farm, spec, id), std::nullopt);
}

TEST(Farm, DoneJobAnswersFromItsFileAfterARestart) {
  Farm farm;
  const JobSpec spec = farm.spec(20, 20, 16, 5);
  JobId id = 0;
  ScriptedWorker worker("once");
  Picture before;
  const auto first = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    id = co_await farm.coordinator->submit(spec);
    co_await worker.work([&] { return farm.coordinator->job(id)->view.state == "done"; });
    before = co_await farm.coordinator->png(id, 1, 0);
    worker.leave();
    co_await farm.halt();
  };
  farm.run(first());
  worker.vanish();
  farm.io.reset();
  farm.start();
  const auto second = [&]() -> awaitable<void> {
    const auto status = farm.coordinator->job(id);
    EXPECT_EQ(status->view.state, "done");
    EXPECT_EQ(status->progress, 1);
    EXPECT_GT(status->rays, 0);
    EXPECT_EQ(status->shares.at(0).worker, "once");
    const Picture after = co_await farm.coordinator->png(id, 1, 0);
    EXPECT_EQ(after.version, before.version);
    EXPECT_EQ(*after.bytes, *before.bytes);
    const Picture all = co_await farm.coordinator->tiles(id, 1, 0);
    const Picture none = co_await farm.coordinator->tiles(id, 1, after.version);
    EXPECT_GT(all.bytes->size(), none.bytes->size() + 20 * 20 * 8 - 1);
  };
  farm.run(second());
}

TEST(Farm, EachFrameOfARangeHasItsFile) {
  Farm farm;
  JobSpec spec = farm.spec(20, 10, 16, 5);
  spec.frames = {3, 7, 2};
  JobId id = 0;
  ScriptedWorker worker("frames");
  const auto scenario = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    id = co_await farm.coordinator->submit(spec);
    co_await worker.work([&] { return farm.coordinator->job(id)->view.state == "done"; });
  };
  farm.run(scenario());
  for (const int frame : {3, 5, 7})
    EXPECT_EQ(difference_from_straight_fold(farm, spec, id, frame), std::nullopt);
}

TEST(Farm, SecondResultOfATaskIsStaleAndChangesNothing) {
  Farm farm;
  const JobSpec spec = farm.spec(30, 20, 16, 20);
  JobId id = 0;
  ScriptedWorker worker("twice");
  worker.on_assign = [&](const wire::Assign& order) {
    worker.deliver(order);
    image::TileImage other = worker.tile_of(order);
    for (float& value : other.values) value = 0.25F;
    worker.deliver(worker.result_of(order), image::encode_tile(other));
  };
  const auto scenario = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    id = co_await farm.coordinator->submit(spec);
    co_await worker.work(
        [&] { return farm.coordinator->job(id)->view.state == "done" && worker.outbox.empty(); });
  };
  farm.run(scenario());
  EXPECT_EQ(worker.accepted, static_cast<std::size_t>(JobPlan(spec).tasks()));
  EXPECT_EQ(worker.stale, worker.accepted);
  EXPECT_EQ(
      farm.coordinator->counters().results_duplicate + farm.coordinator->counters().results_stale,
      worker.stale);
  EXPECT_GT(farm.coordinator->counters().results_duplicate, 0U);
  EXPECT_EQ(difference_from_straight_fold(farm, spec, id), std::nullopt);
}

TEST(Farm, WorkersAreHeldWhileTooMuchIsInFlightAndNothingIsLost) {
  Farm farm;
  farm.run(farm.halt());
  farm.io.reset();
  farm.in_flight = 10'000;  // less than one and a half of its tiles
  farm.start();
  const JobSpec spec = farm.spec(100, 80, 16, 20);
  JobId id = 0;
  ScriptedWorker worker("held");
  const auto scenario = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    id = co_await farm.coordinator->submit(spec);
    co_await worker.work([&] { return farm.coordinator->job(id)->view.state == "done"; });
  };
  farm.run(scenario());
  EXPECT_EQ(worker.accepted, static_cast<std::size_t>(JobPlan(spec).tasks()));
  EXPECT_EQ(worker.ended, "");
  EXPECT_EQ(difference_from_straight_fold(farm, spec, id), std::nullopt);
}

/// A connection that only notes what it is told.
class NotedLink : public WorkerLink {
 public:
  void send(wire::Message message) override { said.push_back(std::move(message)); }
  void close(std::string) override {}
  void hold(bool held) override { holds.push_back(held); }
  std::vector<wire::Message> said;
  std::vector<bool> holds;
};

TEST(Farm, LinksAreHeldBeyondTheBudgetAndReleasedOnceItIsFolded) {
  Farm farm;
  farm.run(farm.halt());
  farm.io.reset();
  farm.in_flight = 10'000;
  farm.start();
  const JobSpec spec = farm.spec(16, 16, 16, 1);
  const JobPlan plan(spec);
  const auto link = std::make_shared<NotedLink>();
  const auto scenario = [&]() -> awaitable<void> {
    WorkerInfo info;
    info.name = "noted";
    info.identity = std::string(32, '4');
    const WorkerId worker = farm.coordinator->worker_joined(info, link);
    const JobId id = co_await farm.coordinator->submit(spec);
    while (link->said.empty()) co_await sleep_for(std::chrono::milliseconds(1));
    const auto order = std::get<wire::Assign>(link->said.at(0));
    wire::Result result;
    result.lease = order.lease;
    result.job = id;
    result.plan = order.plan;
    result.task = order.task;
    result.samples = 256;
    farm.coordinator->worker_result(worker, result,
                                    image::encode_tile(synthetic_tile(plan, order.task)));
    EXPECT_EQ(link->holds, std::vector<bool>{true});
    while (link->holds.size() < 2) co_await sleep_for(std::chrono::milliseconds(1));
    EXPECT_EQ(link->holds, (std::vector<bool>{true, false}));
    farm.coordinator->worker_left(worker, true);
    co_await farm.until_state(id, "done");
  };
  farm.run(scenario());
}

TEST(Farm, ResultThatCannotBeReadBackFailsItsJobAndNoOther) {
  Farm farm;
  JobId broken = 0;
  ScriptedWorker worker("before");
  std::size_t delivered = 0;
  worker.on_assign = [&](const wire::Assign& order) {
    if (delivered++ < 8) worker.deliver(order);
  };
  const auto before = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    broken = co_await farm.coordinator->submit(farm.spec());
    co_await worker.work([&] { return worker.accepted == 8; });
    worker.vanish();
  };
  farm.run(before());
  farm.kill();
  for (const auto& entry : std::filesystem::directory_iterator(farm.data / "journal")) {
    std::fstream segment(entry.path(), std::ios::in | std::ios::out | std::ios::binary);
    for (std::uintmax_t at = 1000; at + 1 < entry.file_size(); at += 1000) {
      segment.seekp(static_cast<std::streamoff>(at));
      segment.put('!');
    }
  }
  farm.start();
  ScriptedWorker good("after", 'b');
  const auto after = [&]() -> awaitable<void> {
    std::string error;
    try {
      co_await farm.coordinator->png(broken, 1, 0);
    } catch (const Error& thrown) {
      error = thrown.what();
    }
    EXPECT_NE(error, "");
    co_await farm.until_state(broken, "failed");
    EXPECT_THAT(farm.coordinator->job(broken)->view.error, HasSubstr("journal"));
    co_await good.connect(farm);
    const JobId sound = co_await farm.coordinator->submit(farm.spec());
    co_await good.work([&] { return farm.coordinator->job(sound)->view.state == "done"; });
  };
  farm.run(after());
}

TEST(Farm, WorkOfAWorkerThatVanishesIsDoneByAnother) {
  Farm farm;
  const JobSpec spec = farm.spec(30, 20, 16, 20);
  JobId id = 0;
  ScriptedWorker gone("gone", 'e');
  ScriptedWorker other("other", 'f');
  std::size_t orders = 0;
  gone.on_assign = [&](const wire::Assign&) { ++orders; };
  const auto scenario = [&]() -> awaitable<void> {
    co_await gone.connect(farm);
    id = co_await farm.coordinator->submit(spec);
    co_await gone.work([&] { return orders > 0; });
    gone.vanish();
    const auto lost = std::chrono::steady_clock::now();
    co_await other.connect(farm);
    co_await other.work([&] { return farm.coordinator->job(id)->view.state == "done"; });
    EXPECT_LT(std::chrono::steady_clock::now() - lost, std::chrono::seconds(3));
  };
  farm.run(scenario());
  EXPECT_EQ(difference_from_straight_fold(farm, spec, id), std::nullopt);
}

}  // namespace
}  // namespace tessera::server
