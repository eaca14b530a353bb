#include <gmock/gmock.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "server/store/store.hpp"
#include "tests/unit/session/farm.hpp"

namespace tessera::server {
namespace {

using testing::HasSubstr;

/// The kind of Error that the coroutine throws, and its message.
template <class T>
awaitable<std::pair<std::optional<ErrorKind>, std::string>> error_of(awaitable<T> call) {
  std::pair<std::optional<ErrorKind>, std::string> found;
  try {
    co_await std::move(call);
  } catch (const Error& error) {
    found = {error.kind(), error.what()};
  }
  co_return found;
}

TEST(Jobs, SubmitRefusesWhatIsWrongOrNotHere) {
  Farm farm;
  const auto scenario = [&]() -> awaitable<void> {
    JobSpec wrong = farm.spec();
    wrong.render.width = 0;
    auto error = co_await error_of(farm.coordinator->submit(wrong));
    EXPECT_EQ(error.first, ErrorKind::bad_input);
    EXPECT_THAT(error.second, HasSubstr("render.width"));

    JobSpec unknown = farm.spec();
    unknown.bundle.bytes[3] ^= 1;
    error = co_await error_of(farm.coordinator->submit(unknown));
    EXPECT_EQ(error.first, ErrorKind::conflict);
    EXPECT_THAT(error.second, HasSubstr(unknown.bundle.hex()));

    assets::BlobStore blobs(farm.data / "blobs", false);
    assets::Bundle bundle;
    bundle.scene = "scene.json";
    bundle.files["scene.json"] = {digest_of("never uploaded"), 14};
    JobSpec lacking = farm.spec();
    const std::string manifest = assets::canonical_json(bundle);
    lacking.bundle = blobs.put(std::as_bytes(std::span(manifest)));
    error = co_await error_of(farm.coordinator->submit(lacking));
    EXPECT_EQ(error.first, ErrorKind::conflict);
    EXPECT_THAT(error.second, HasSubstr("scene.json"));
    EXPECT_TRUE(farm.coordinator->jobs().empty());
  };
  farm.run(scenario());
}

TEST(Jobs, WorkersAreNotToldNamesForManifests) {
  Farm farm;
  ScriptedWorker worker("one");
  JobSpec spec = farm.spec();
  spec.cryptomatte = {.objects = {"floor"}, .materials = {"white"}};
  JobId id = 0;
  std::optional<JobSpec> told;
  worker.on_assign = [&](const wire::Assign& order) {
    if (order.spec) told = order.spec;
    EXPECT_EQ(order.plan, JobPlan(spec).digest);
  };
  const auto scenario = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    id = co_await farm.coordinator->submit(spec);
    co_await worker.work([&] { return told.has_value(); });
  };
  farm.run(scenario());
  EXPECT_TRUE(told->cryptomatte.empty());
  EXPECT_FALSE(nlohmann::json(to_json(*told)).contains("cryptomatte"));
  EXPECT_EQ(farm.coordinator->job(id)->plan->spec.cryptomatte, spec.cryptomatte);
}

TEST(Jobs, CancelledOneKeepsItsPictureAndIsNoLongerWorkedOn) {
  Farm farm;
  JobId id = 0;
  ScriptedWorker worker("half");
  const JobSpec spec = farm.spec(64, 64, 16, 300);
  std::size_t delivered = 0;
  worker.on_assign = [&](const wire::Assign& order) {
    if (delivered < 6) worker.deliver(order);
    ++delivered;
  };
  const auto scenario = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    id = co_await farm.coordinator->submit(spec);
    co_await worker.work([&] { return worker.accepted == 6; });
    // A result is acknowledged before it is folded; what is kept is what was folded.
    while (farm.coordinator->version(id, 1).value_or(0) == 0)
      co_await sleep_for(std::chrono::milliseconds(5));
    co_await farm.coordinator->cancel(id);
    EXPECT_EQ(farm.coordinator->job(id)->view.state, "cancelled");
    co_await worker.work([&] { return worker.revoked > 0; });
    const auto error = co_await error_of(farm.coordinator->cancel(id));
    EXPECT_EQ(error.first, ErrorKind::conflict);
    while (!std::filesystem::exists(farm.final_file(id)))
      co_await sleep_for(std::chrono::milliseconds(5));
    const Picture picture = co_await farm.coordinator->exr(id, 1);
    const image::ExrImage exr = image::read_exr(*picture.bytes);
    EXPECT_GT(*std::max_element(exr.plane("A").begin(), exr.plane("A").end()), 0.0F);
    EXPECT_EQ(*std::min_element(exr.plane("samples").begin(), exr.plane("samples").end()), 0.0F);
    co_await farm.halt();
  };
  farm.run(scenario());
  worker.vanish();
  farm.io.reset();
  farm.start();
  EXPECT_EQ(farm.coordinator->job(id)->view.state, "cancelled");
}

TEST(Jobs, PausedOneIsGrantedNothingUntilItIsResumedAlsoOverARestart) {
  Farm farm;
  JobId id = 0;
  const JobSpec spec = farm.spec(40, 40, 16, 5);
  const auto first = [&]() -> awaitable<void> {
    id = co_await farm.coordinator->submit(spec);
    co_await farm.coordinator->pause(id);
    JobChange change;
    change.priority = 7;
    change.max_workers = 3;
    change.focus = Rect{16, 0, 20, 9};
    co_await farm.coordinator->change(id, change);
    co_await farm.halt();
  };
  farm.run(first());
  farm.io.reset();
  farm.start();
  ScriptedWorker worker("patient");
  const auto second = [&]() -> awaitable<void> {
    EXPECT_EQ(farm.coordinator->job(id)->view.state, "paused");
    EXPECT_EQ(farm.coordinator->job(id)->view.priority, 7);
    EXPECT_EQ(farm.coordinator->job(id)->plan->spec.max_workers, 3);
    EXPECT_EQ(farm.coordinator->job(id)->plan->spec.focus, (Rect{16, 0, 20, 9}));
    JobChange wrong;
    wrong.priority = 9;
    wrong.focus = Rect{16, 0, 25, 9};
    const auto beyond = co_await error_of(farm.coordinator->change(id, wrong));
    EXPECT_EQ(beyond.first, ErrorKind::bad_input);
    EXPECT_THAT(beyond.second, HasSubstr("focus.width"));
    EXPECT_EQ(farm.coordinator->job(id)->view.priority, 7) << "all of a change or nothing";
    co_await worker.connect(farm);
    const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds(200);
    co_await worker.work([&] { return std::chrono::steady_clock::now() > until; });
    EXPECT_EQ(worker.accepted, 0U);
    co_await farm.coordinator->resume(id);
    co_await worker.work([&] { return farm.coordinator->job(id)->view.state == "done"; });
    const auto error = co_await error_of(farm.coordinator->pause(id));
    EXPECT_EQ(error.first, ErrorKind::conflict);
    EXPECT_THAT(error.second, HasSubstr("is done"));
    const auto unknown = co_await error_of(farm.coordinator->resume(99));
    EXPECT_EQ(unknown.first, ErrorKind::not_found);
  };
  farm.run(second());
}

TEST(Jobs, WhatWasCountedBeforeAPauseIsNotCountedAgainAfterARestart) {
  Farm farm;
  JobId id = 0;
  std::int64_t rays = 0;
  const JobSpec spec = farm.spec(64, 64, 16, 300);
  ScriptedWorker worker("half");
  std::size_t delivered = 0;
  worker.on_assign = [&](const wire::Assign& order) {
    if (delivered++ < 3) worker.deliver(order);
  };
  const auto first = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    id = co_await farm.coordinator->submit(spec);
    co_await worker.work([&] { return worker.accepted == 3; });
    rays = farm.coordinator->job(id)->rays;
    EXPECT_GT(rays, 0);
    co_await farm.coordinator->pause(id);
    co_await farm.halt();
  };
  farm.run(first());
  worker.vanish();
  farm.io.reset();
  farm.start();
  EXPECT_EQ(farm.coordinator->job(id)->rays, rays);
}

TEST(Jobs, NoResultOfAnEndedJobStaysInTheJournalOverAStart) {
  Farm farm;
  JobId id = 0;
  const JobSpec spec = farm.spec(64, 64, 16, 300);
  ScriptedWorker worker("half");
  std::size_t delivered = 0;
  worker.on_assign = [&](const wire::Assign& order) {
    if (delivered++ < 3) worker.deliver(order);
  };
  const auto scenario = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    id = co_await farm.coordinator->submit(spec);
    co_await worker.work([&] { return worker.accepted == 3; });
    co_await farm.halt();
  };
  farm.run(scenario());
  worker.vanish();
  farm.io.reset();
  {
    // As if the process had died between the end of the job and that of its results.
    const auto store = Store::open(farm.data, {.durable = false});
    EXPECT_EQ(store->jobs_with_results(), std::vector<JobId>{id});
    JobRecord record = store->list_jobs().at(0);
    record.state = "cancelled";
    store->update_job(record);
  }
  farm.start();
  const auto second = [&]() -> awaitable<void> {
    while (farm.coordinator->storage().journal > 0)
      co_await sleep_for(std::chrono::milliseconds(5));
    co_await farm.coordinator->png(id, 1, 0);  // of what it had
    co_await farm.halt();
  };
  farm.run(second());
  const auto store = Store::open(farm.data, {.durable = false});
  EXPECT_TRUE(store->jobs_with_results().empty());
}

TEST(Jobs, AResultWithMoreRaysThanItsTaskCanTraceIsRejected) {
  Farm farm;
  ScriptedWorker worker("liar");
  bool lied = false;
  worker.on_assign = [&](const wire::Assign& order) {
    if (lied) return;
    lied = true;
    wire::Result result = worker.result_of(order);
    result.rays = std::numeric_limits<std::int64_t>::max();
    worker.deliver(result, image::encode_tile(worker.tile_of(order)));
  };
  const auto scenario = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    const JobId id = co_await farm.coordinator->submit(farm.spec());
    co_await worker.work([&] { return !worker.rejected.empty(); });
    EXPECT_EQ(worker.rejected.size(), 1U);
    EXPECT_EQ(farm.coordinator->job(id)->rays, 0);
    EXPECT_THAT(worker.rejected.at(0).reason, HasSubstr("rays"));
  };
  farm.run(scenario(), std::chrono::seconds(10));
}

TEST(Jobs, PictureOfAVersionIsEncodedOnceForAllWhoAsk) {
  Farm farm;
  const auto scenario = [&]() -> awaitable<void> {
    const JobId id = co_await farm.coordinator->submit(farm.spec(200, 100));
    std::vector<Picture> pictures(4);
    std::vector<std::shared_ptr<bool>> asked;
    const auto ask = [&](std::size_t i) -> awaitable<void> {
      pictures[i] = co_await farm.coordinator->png(id, 1, 0);
    };
    for (std::size_t i = 0; i < pictures.size(); ++i) asked.push_back(farm.go(ask(i)));
    for (const auto& ended : asked)
      while (!*ended) co_await sleep_for(std::chrono::milliseconds(1));
    for (const Picture& picture : pictures) EXPECT_EQ(picture.bytes, pictures[0].bytes);
    EXPECT_EQ(pictures[0].version, 0U);
    const auto other = co_await farm.coordinator->png(id, 1, 1);
    EXPECT_NE(other.bytes, pictures[0].bytes);
    const auto no_frame = co_await error_of(farm.coordinator->png(id, 2, 0));
    EXPECT_EQ(no_frame.first, ErrorKind::not_found);
  };
  farm.run(scenario());
}

TEST(Jobs, ListenersHearOfWorkersJobsAndPictures) {
  Farm farm;
  ScriptedWorker worker("heard");
  const auto scenario = [&]() -> awaitable<void> {
    const auto all = farm.coordinator->subscribe(std::nullopt);
    co_await worker.connect(farm);
    const JobId id = co_await farm.coordinator->submit(farm.spec());
    const auto one = farm.coordinator->subscribe(id);
    co_await worker.work([&] { return farm.coordinator->job(id)->view.state == "done"; });
    worker.leave();
    std::set<std::string> types;
    std::string last_state, last_worker;
    std::uint64_t number = 0, last_version = 0;
    for (auto event = co_await all->next(std::chrono::seconds(1)); event;
         event = co_await all->next(std::chrono::milliseconds(600))) {
      EXPECT_GT(event->number, number);
      number = event->number;
      types.insert(event->type);
      const auto data = nlohmann::json::parse(event->data);
      if (event->type == "job") last_state = data["state"];
      if (event->type == "worker") last_worker = data["state"];
      if (event->type == "frame") last_version = data["version"];
    }
    EXPECT_THAT(types, testing::ElementsAre("frame", "job", "worker"));
    EXPECT_EQ(last_state, "done");
    EXPECT_EQ(last_worker, "left");
    EXPECT_EQ(last_version, farm.coordinator->version(id, 1));
    for (auto event = co_await one->next(std::chrono::milliseconds(10)); event;
         event = co_await one->next(std::chrono::milliseconds(10)))
      EXPECT_EQ(event->job, id);
  };
  farm.run(scenario());
}

TEST(Jobs, StopEndsWhatListenersWaitFor) {
  Farm farm;
  const auto scenario = [&]() -> awaitable<void> {
    const auto all = farm.coordinator->subscribe(std::nullopt);
    bool nothing = false;
    const auto listen = [&]() -> awaitable<void> {
      nothing = !(co_await all->next(std::chrono::minutes(1))).has_value();
    };
    const auto listening = farm.go(listen());
    co_await sleep_for(std::chrono::milliseconds(5));
    co_await farm.halt();
    while (!*listening) co_await sleep_for(std::chrono::milliseconds(1));
    EXPECT_TRUE(nothing);
  };
  farm.run(scenario());
}

TEST(Jobs, TwoCoordinatorsDoNotShareAFolder) {
  Farm farm;
  CoordinatorSettings settings;
  settings.data = farm.data;
  try {
    Coordinator::open(farm.io->get_executor(), settings);
    FAIL() << "a second coordinator opened the folder";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::conflict);
    EXPECT_THAT(error.what(), HasSubstr(farm.data.string()));
  }
}

}  // namespace
}  // namespace tessera::server
