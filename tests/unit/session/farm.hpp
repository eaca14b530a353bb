#pragma once
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/assets/blob_store.hpp"
#include "common/assets/bundle.hpp"
#include "common/base/error.hpp"
#include "common/net/framed_stream.hpp"
#include "server/coordinator/coordinator.hpp"
#include "server/session/listener.hpp"
#include "tests/unit/session/synthetic.hpp"

/// A real coordinator and its workers' port on loopback, over a folder of its own, with workers
/// that render nothing.
namespace tessera::server {

using boost::asio::awaitable;

inline awaitable<void> sleep_for(Duration time) {
  boost::asio::steady_timer timer(co_await boost::asio::this_coro::executor, time);
  co_await timer.async_wait(boost::asio::as_tuple(boost::asio::use_awaitable));
}

/// What kind of Error `coroutine` throws; nothing if it throws none.
template <class Result>
awaitable<std::optional<ErrorKind>> refusal_of(awaitable<Result> coroutine) {
  std::optional<ErrorKind> kind;
  try {
    co_await std::move(coroutine);
  } catch (const Error& error) {
    kind = error.kind();
  }
  co_return kind;
}

class Farm {
 public:
  Farm() {
    std::string name = (std::filesystem::temp_directory_path() / "tessera-farm-XXXXXX").string();
    data = ::mkdtemp(name.data());
    start();
  }
  ~Farm() {
    if (coordinator) run(halt());
    std::error_code ignored;
    std::filesystem::remove_all(data, ignored);
  }
  Farm(const Farm&) = delete;
  Farm& operator=(const Farm&) = delete;

  void start() {
    io = std::make_unique<boost::asio::io_context>(1);
    CoordinatorSettings settings;
    settings.data = data;
    settings.durable = false;
    settings.in_flight = in_flight;
    settings.film_memory = film_memory;
    settings.keep_jobs = keep_jobs;
    settings.blob_grace = blob_grace;
    settings.blob_cache = blob_cache;
    settings.upkeep = upkeep;
    settings.patience = patience;
    settings.disk_limit = disk_limit;
    settings.scheduler.silence = silence;
    coordinator = Coordinator::open(io->get_executor(), settings);
    SessionSettings sessions = session_settings;
    sessions.port = 0;
    listener = WorkerListener::open(io->get_executor(), *coordinator, sessions);
  }
  awaitable<void> halt() {
    co_await listener->stop();
    co_await coordinator->stop();
    listener.reset();
    coordinator.reset();
  }
  /// As if the process were killed: nothing is finished, nobody is told.
  void kill() {
    listener.reset();
    coordinator.reset();
    io.reset();
  }
  [[nodiscard]] bool done(JobId job) const { return coordinator->job(job)->view.state == "done"; }
  /// Starts a coroutine beside the scenario; true in what is given back once it has ended.
  std::shared_ptr<bool> go(awaitable<void> coroutine) {
    auto ended = std::make_shared<bool>(false);
    boost::asio::co_spawn(*io, std::move(coroutine), [ended](const std::exception_ptr& error) {
      *ended = true;
      if (error) ADD_FAILURE() << "a coroutine beside the scenario has thrown";
    });
    return ended;
  }

  /// Runs until the coroutine has ended; what it throws fails the test.
  void run(awaitable<void> scenario, Duration most = std::chrono::seconds(60)) {
    bool ended = false;
    std::string thrown;
    boost::asio::co_spawn(*io, std::move(scenario), [&](const std::exception_ptr& error) {
      ended = true;
      try {
        if (error) std::rethrow_exception(error);
      } catch (const std::exception& unexpected) {
        thrown = unexpected.what();
      }
    });
    const auto end = std::chrono::steady_clock::now() + most;
    io->restart();
    while (!ended && std::chrono::steady_clock::now() < end)
      io->run_one_for(std::chrono::milliseconds(100));
    EXPECT_TRUE(ended) << "the scenario did not end in time";
    EXPECT_EQ(thrown, "");
  }

  /// Blobs of a scene that nobody reads; the bundle's digest.
  [[nodiscard]] Digest put_bundle() const {
    assets::BlobStore blobs(data / "blobs", false);
    const std::string scene = "{}";
    assets::Bundle bundle;
    bundle.scene = "scene.json";
    bundle.files["scene.json"] = {blobs.put(std::as_bytes(std::span(scene))), scene.size()};
    const std::string manifest = assets::canonical_json(bundle);
    return blobs.put(std::as_bytes(std::span(manifest)));
  }
  [[nodiscard]] JobSpec spec(int width = 50, int height = 37, int tile = 16,
                             std::int64_t samples = 20) const {
    JobSpec spec;
    spec.name = "synthetic";
    spec.bundle = put_bundle();
    spec.render.width = width;
    spec.render.height = height;
    spec.render.samples = samples;
    spec.tile = tile;
    return spec;
  }
  awaitable<void> until_state(JobId id, std::string state) {
    while (coordinator->job(id)->view.state != state)
      co_await sleep_for(std::chrono::milliseconds(5));
  }
  [[nodiscard]] std::filesystem::path final_file(JobId id, int frame = 1) const {
    return data / "jobs" / std::to_string(id) / fmt::format("frame-{:04}.exr", frame);
  }

  SessionSettings session_settings;
  std::size_t in_flight = 256 * limits::MiB;
  std::uint64_t film_memory = 256 * limits::MiB;
  std::optional<Duration> keep_jobs;
  Duration blob_grace = std::chrono::hours(24), upkeep = std::chrono::seconds(5);
  Duration patience = std::chrono::seconds(20);
  Duration silence = SchedulerSettings{}.silence;
  std::uint64_t disk_limit = 0, blob_cache = 0;
  std::filesystem::path data;
  std::unique_ptr<boost::asio::io_context> io;
  std::unique_ptr<Coordinator> coordinator;
  std::unique_ptr<WorkerListener> listener;
};

/// A worker that sends synthetic tiles. What it does with an order can be replaced.
class ScriptedWorker {
 public:
  explicit ScriptedWorker(std::string name, char digit = 'a')
      : name_(std::move(name)), identity_(32, digit) {}

  awaitable<void> connect(Farm& farm) {
    net::Address address;
    address.port = farm.listener->port();
    stream_ = std::make_unique<net::FramedStream>(co_await net::FramedStream::connect(
        farm.io->get_executor(), address, std::chrono::seconds(5)));
    wire::Hello hello;
    hello.token = token;
    hello.name = name_;
    hello.identity = identity_;
    hello.threads = 1;
    hello.version = "test";
    stream_->send(hello);
    const auto answer = co_await stream_->receive(std::chrono::seconds(5));
    welcome = std::get<wire::Welcome>(answer.value().message);
    stream_->welcomed();
    for (auto& [lease, held] : outbox) offer(held);
  }

  /// Works until the connection ends or `enough` says so. `on_assign` replaces the answer to an
  /// order.
  awaitable<void> work(std::function<bool()> enough) {
    while (!enough()) {
      std::optional<net::Incoming> incoming;
      try {
        incoming = co_await stream_->receive(std::chrono::milliseconds(20));
      } catch (const Error& error) {
        ended = error.what();
        co_return;
      }
      if (incoming) take(incoming->message);
      if (!incoming && on_idle) on_idle();
    }
  }
  void leave() { stream_->send(wire::Bye{"done"}); }
  void vanish() { stream_.reset(); }

  wire::Result result_of(const wire::Assign& order) const {
    const JobPlan& plan = *plans_.at(order.job);
    wire::Result result;
    result.lease = order.lease;
    result.job = order.job;
    result.plan = order.plan;
    result.task = order.task;
    result.samples =
        plan.grid.tile(order.task.tile).pixels() * plan.passes.pass(order.task.pass).count;
    result.rays = 2 * result.samples;
    result.seconds = 0.001;
    return result;
  }
  [[nodiscard]] image::TileImage tile_of(const wire::Assign& order) const {
    return synthetic_tile(*plans_.at(order.job), order.task);
  }
  void deliver(const wire::Assign& order) {
    deliver(result_of(order), image::encode_tile(tile_of(order)));
  }
  void deliver(const wire::Result& result, std::vector<std::byte> exr) {
    Held held{result, std::make_shared<const std::vector<std::byte>>(std::move(exr))};
    outbox[result.lease] = held;
    offer(held);
  }

  struct Held {
    wire::Result result;
    std::shared_ptr<const std::vector<std::byte>> exr;
  };

  std::string token;
  wire::Welcome welcome;
  std::map<LeaseId, Held> outbox;
  std::vector<wire::Rejected> rejected;
  std::size_t accepted = 0, stale = 0, revoked = 0;
  std::string ended, bye;
  std::vector<std::string> told;  ///< by revokes without leases
  std::function<void(const wire::Assign&)> on_assign;
  std::function<void()> on_idle;
  [[nodiscard]] net::FramedStream& stream() { return *stream_; }

 private:
  void offer(const Held& held) { stream_->send(held.result, held.exr); }

  void take(const wire::Message& message) {
    if (const auto* assign = std::get_if<wire::Assign>(&message)) {
      if (assign->spec) {
        plans_[assign->job] = std::make_shared<const JobPlan>(*assign->spec);
        stream_->send(wire::Preparing{assign->job, 0.5});
        stream_->send(wire::Ready{assign->job});
      }
      EXPECT_TRUE(plans_.contains(assign->job)) << "an order without its job's spec";
      if (on_assign) {
        on_assign(*assign);
      } else {
        deliver(*assign);
      }
    } else if (const auto* taken = std::get_if<wire::Accepted>(&message)) {
      ++accepted;
      outbox.erase(taken->lease);
    } else if (const auto* late = std::get_if<wire::Stale>(&message)) {
      ++stale;
      outbox.erase(late->lease);
    } else if (const auto* refused = std::get_if<wire::Rejected>(&message)) {
      rejected.push_back(*refused);
      outbox.erase(refused->lease);
    } else if (const auto* revoke = std::get_if<wire::Revoke>(&message)) {
      revoked += revoke->leases.size();
      if (revoke->leases.empty()) told.push_back(revoke->reason);
    } else if (const auto* last = std::get_if<wire::Bye>(&message)) {
      bye = last->reason;
    }
  }

  std::string name_;
  std::string identity_;
  std::unique_ptr<net::FramedStream> stream_;
  std::map<JobId, std::shared_ptr<const JobPlan>> plans_;
};

/// Nothing if the job's final file has the bits of a straight fold.
inline std::optional<std::string> difference_from_straight_fold(const Farm& farm,
                                                                const JobSpec& spec, JobId id,
                                                                int frame = 1) {
  return image::difference(image::read_exr_file(farm.final_file(id, frame)),
                           expected_exr(JobPlan(spec), frame));
}

}  // namespace tessera::server
