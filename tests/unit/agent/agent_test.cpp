#include "worker/agent/agent.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "common/base/random.hpp"
#include "common/image/tile.hpp"
#include "common/net/framed_stream.hpp"
#include "common/wire/codec.hpp"
#include "tests/unit/agent/blob_server.hpp"
#include "tests/unit/agent/fakes.hpp"

namespace tessera::agent {
namespace {

namespace asio = boost::asio;
using namespace std::chrono_literals;
using net::FramedStream;

/// A real agent with a fake renderer, and a coordinator that each test plays, on one I/O thread.
class AgentTest : public testing::Test {
 protected:
  asio::io_context io{1};
  asio::ip::tcp::acceptor acceptor = net::listen(io.get_executor(), {"127.0.0.1", 0});
  std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / ("agent-" + random_hex(6));
  BlobServer blobs;
  Digest bundle = blobs.add_scene("{}", "mesh");
  JobPlan plan{test_spec(bundle)};
  FakeRenderer renderer{1};
  std::optional<int> exit_code;
  std::uint64_t epoch = 1;
  std::size_t scenes_kept = 2;

  ~AgentTest() override { std::filesystem::remove_all(folder); }

  std::uint16_t port = acceptor.local_endpoint().port();

  AgentSettings settings() const {
    AgentSettings made;
    made.server = {"127.0.0.1", port};
    made.token = "join";
    made.name = "tester";
    made.cache = folder;
    made.fetch.patience.first_wait = 1ms;
    made.state.backoff_first = 5ms;
    made.state.backoff_most = 20ms;
    made.drain_wait = 300ms;
    made.drain_alone_wait = 100ms;
    made.state.scenes_kept = scenes_kept;
    return made;
  }

  using Play = std::function<asio::awaitable<void>(Agent&)>;
  void play(const Play& coordinator) {
    Agent agent(io, settings(), renderer);
    std::exception_ptr failure;
    bool played = false;
    asio::co_spawn(io, agent.run(), [&](std::exception_ptr error, int code) {
      if (error) failure = error;
      exit_code = code;
    });
    asio::co_spawn(io, coordinator(agent), [&](std::exception_ptr error) {
      if (error) failure = error;
      played = true;
      if (!exit_code) agent.drain("the test is over");
    });
    const auto end = std::chrono::steady_clock::now() + 20s;
    while (!(played && exit_code) && !failure && std::chrono::steady_clock::now() < end)
      io.run_one_for(50ms);
    if (failure) std::rethrow_exception(failure);
    ASSERT_TRUE(played && exit_code) << "it did not end";
  }

  /// Accepts the agent's next connection and welcomes it.
  asio::awaitable<std::unique_ptr<FramedStream>> welcome(wire::Hello* hello = nullptr) {
    asio::ip::tcp::socket socket = co_await acceptor.async_accept(asio::use_awaitable);
    auto stream = std::make_unique<FramedStream>(std::move(socket));
    const std::optional<net::Incoming> first = co_await stream->receive(5s);
    if (!first) throw std::runtime_error("no hello");
    if (hello != nullptr) *hello = std::get<wire::Hello>(first->message);
    stream->welcomed();
    wire::Welcome answer;
    answer.worker = 1;
    answer.epoch = epoch;
    answer.heartbeat_ms = 50;
    answer.blob_url = blobs.url();
    answer.blob_token = "blobs";
    stream->send(answer);
    co_return stream;
  }
  /// The next message of type T; others are passed over.
  template <class T>
  asio::awaitable<T> next(FramedStream& stream, std::vector<std::byte>* body = nullptr) {
    while (true) {
      std::optional<net::Incoming> incoming = co_await stream.receive(5s);
      if (!incoming) throw std::runtime_error("nothing came");
      if (const T* message = std::get_if<T>(&incoming->message)) {
        if (body != nullptr) *body = std::move(incoming->body);
        co_return *message;
      }
      if (!std::holds_alternative<wire::Preparing>(incoming->message) &&
          !std::holds_alternative<wire::Progress>(incoming->message) &&
          !std::holds_alternative<wire::Ready>(incoming->message))
        throw std::runtime_error("another message came: " +
                                 std::string(wire::name_of(wire::type_of(incoming->message))));
    }
  }
  LeaseId assign(FramedStream& stream, std::uint32_t tile, std::uint32_t pass = 0,
                 bool with_spec = true) {
    wire::Assign message;
    message.lease = {.epoch = epoch, .number = 1000 * epoch + tile + 100 * pass};
    message.job = 1;
    message.plan = plan.digest;
    message.task = {1, tile, pass};
    if (with_spec) message.spec = plan.spec;
    stream.send(message);
    return message.lease;
  }
  /// The first task of a job with a scene of its own.
  LeaseId assign_other(FramedStream& stream, JobId job) {
    const JobPlan other(test_spec(blobs.add_scene("{}", "mesh " + std::to_string(job))));
    wire::Assign message;
    message.lease = {.epoch = epoch, .number = 10'000 * job};
    message.job = job;
    message.plan = other.digest;
    message.task = {1, 0, 0};
    message.spec = other.spec;
    stream.send(message);
    return message.lease;
  }
  asio::awaitable<void> pause(Duration time) {
    asio::steady_timer timer(io, time);
    co_await timer.async_wait(asio::use_awaitable);
  }
};

TEST_F(AgentTest, it_says_who_it_is_prepares_renders_and_delivers) {
  play([this](Agent&) -> asio::awaitable<void> {
    wire::Hello hello;
    const auto stream = co_await welcome(&hello);
    EXPECT_EQ(hello.token, "join");
    EXPECT_EQ(hello.name, "tester");
    EXPECT_EQ(hello.threads, 1);
    EXPECT_EQ(hello.build_id, digest_of("fake"));
    const LeaseId lease = assign(*stream, 5);
    co_await next<wire::Preparing>(*stream);
    co_await next<wire::Ready>(*stream);
    std::vector<std::byte> body;
    const wire::Result result = co_await next<wire::Result>(*stream, &body);
    EXPECT_EQ(result.lease, lease);
    EXPECT_EQ(result.task, (TaskId{1, 5, 0}));
    EXPECT_EQ(result.samples, 256);
    EXPECT_EQ(image::decode_tile(body, {.window = plan.grid.tile(5),
                                        .film_width = 64,
                                        .film_height = 48,
                                        .samples = 1,
                                        .aovs = true})
                  .pixels(),
              256U);
    stream->send(wire::Accepted{.lease = lease});
    const LeaseId second = assign(*stream, 6, 0, false);
    const wire::Result again = co_await next<wire::Result>(*stream);
    EXPECT_EQ(again.lease, second);
    EXPECT_EQ(renderer.prepared, 1) << "the scene is kept";
    EXPECT_EQ(renderer.last_files.size(), 2U);
    stream->send(wire::Accepted{.lease = second});
  });
  EXPECT_EQ(exit_code, 0);
}

TEST_F(AgentTest, heartbeats_go_on_while_it_prepares_and_while_it_renders) {
  renderer.hold_prepare = true;
  renderer.hold = true;
  play([this](Agent&) -> asio::awaitable<void> {
    const auto stream = co_await welcome();
    const LeaseId lease = assign(*stream, 0);
    for (int i = 0; i < 3; ++i) co_await next<wire::Progress>(*stream);
    for (int i = 0; i < 3; ++i) co_await next<wire::Preparing>(*stream);
    renderer.hold_prepare = false;
    co_await next<wire::Ready>(*stream);
    wire::Progress progress;
    for (int i = 0; i < 20 && progress.running.empty(); ++i)
      progress = co_await next<wire::Progress>(*stream);
    EXPECT_EQ(progress.running.size(), 1U);
    renderer.hold = false;
    co_await next<wire::Result>(*stream);
    stream->send(wire::Accepted{.lease = lease});
  });
}

TEST_F(AgentTest, heartbeats_go_on_while_a_scene_is_freed_and_no_other_is_built_till_then) {
  std::atomic<bool> hold_free = true, freeing = false;
  const std::thread::id io_thread = std::this_thread::get_id();
  renderer.on_freed = [&] {
    if (!hold_free) return;  // the agent's end
    EXPECT_NE(std::this_thread::get_id(), io_thread);
    freeing = true;
    for (int i = 0; hold_free && i < 5000; ++i) std::this_thread::sleep_for(1ms);
  };
  renderer.hold = true;
  scenes_kept = 1;
  play([&](Agent& agent) -> asio::awaitable<void> {
    const auto stream = co_await welcome();
    assign(*stream, 0);
    assign(*stream, 1, 0, false);  // and so the threads have all that they take
    for (int i = 0; i < 400 && renderer.active == 0; ++i) co_await pause(5ms);
    for (const JobId job : {2, 3}) {
      const LeaseId lease = assign_other(*stream, job);
      while ((co_await next<wire::Ready>(*stream)).job != job) continue;
      stream->send(wire::Revoke{.leases = {lease}, .reason = "cancelled"});
    }
    for (int i = 0; i < 400 && !freeing; ++i) co_await pause(5ms);
    EXPECT_TRUE(freeing) << "the second job's is let go of for the third's";
    const LeaseId lease = assign_other(*stream, 4);
    for (int i = 0; i < 3; ++i) co_await next<wire::Progress>(*stream);
    for (int i = 0; i < 3; ++i) co_await next<wire::Preparing>(*stream);
    EXPECT_EQ(renderer.prepared, 3);
    hold_free = false;
    while ((co_await next<wire::Ready>(*stream)).job != 4) continue;
    EXPECT_EQ(renderer.prepared, 4);
    stream->send(wire::Revoke{.leases = {lease}, .reason = "cancelled"});
    renderer.hold = false;
    for (int i = 0; i < 2; ++i)
      stream->send(wire::Accepted{.lease = (co_await next<wire::Result>(*stream)).lease});
    agent.drain("asked to");
    co_await next<wire::Drain>(*stream);
    co_await next<wire::Bye>(*stream);
  });
}

TEST_F(AgentTest, it_waits_for_a_coordinator_that_is_not_there_yet) {
  acceptor.close();
  play([this](Agent&) -> asio::awaitable<void> {
    co_await pause(100ms);
    acceptor = net::listen(io.get_executor(), {"127.0.0.1", port});
    const auto stream = co_await welcome();
    EXPECT_TRUE(stream->is_open());
  });
}

TEST_F(AgentTest, it_comes_back_as_the_same_and_offers_what_it_could_not_deliver) {
  play([this](Agent&) -> asio::awaitable<void> {
    wire::Hello before, after;
    auto stream = co_await welcome(&before);
    const LeaseId first = assign(*stream, 0);
    const wire::Result sent = co_await next<wire::Result>(*stream);
    EXPECT_EQ(sent.lease, first);
    renderer.hold = true;
    const LeaseId second = assign(*stream, 1, 0, false);
    for (int i = 0; i < 100 && renderer.active == 0; ++i) co_await pause(5ms);
    stream.reset();  // gone before the first was acknowledged, while the second renders
    ++epoch;
    stream = co_await welcome(&after);
    EXPECT_EQ(after.identity, before.identity);
    const wire::Result offered = co_await next<wire::Result>(*stream);
    EXPECT_EQ(offered.lease, first);
    renderer.hold = false;
    const wire::Result finished = co_await next<wire::Result>(*stream);
    EXPECT_EQ(finished.lease, second);
    stream->send(wire::Accepted{.lease = first});
    stream->send(wire::Stale{.lease = second});
    const LeaseId third = assign(*stream, 2);
    const wire::Result fresh = co_await next<wire::Result>(*stream);
    EXPECT_EQ(fresh.lease, third);
    EXPECT_EQ(renderer.prepared, 1);
    stream->send(wire::Accepted{.lease = third});
  });
}

TEST_F(AgentTest, a_drain_finishes_what_renders_gives_the_rest_back_and_says_bye) {
  renderer.hold = true;
  play([this](Agent& agent) -> asio::awaitable<void> {
    const auto stream = co_await welcome();
    const LeaseId lease = assign(*stream, 0);
    for (std::uint32_t tile = 1; tile < 12; ++tile) assign(*stream, tile, 0, false);
    co_await next<wire::Ready>(*stream);
    for (int i = 0; i < 100 && renderer.active == 0; ++i) co_await pause(5ms);
    agent.drain("asked to");
    co_await next<wire::Drain>(*stream);
    renderer.hold = false;
    const wire::Result result = co_await next<wire::Result>(*stream);
    EXPECT_EQ(result.lease, lease);
    stream->send(wire::Accepted{.lease = lease});
    // What waits behind it in the crew is finished too; the rest is given back.
    int more = 0;
    bool left = false;
    while (!left) {
      const std::optional<net::Incoming> incoming = co_await stream->receive(5s);
      if (!incoming) throw std::runtime_error("no bye");
      if (const auto* other = std::get_if<wire::Result>(&incoming->message)) {
        ++more;
        stream->send(wire::Accepted{.lease = other->lease});
      }
      left = std::holds_alternative<wire::Bye>(incoming->message);
    }
    EXPECT_LE(more, 1);
  });
  EXPECT_EQ(exit_code, 0);
}

TEST_F(AgentTest, a_drain_does_not_wait_for_ever_for_a_task_that_takes_long) {
  renderer.hold = true;
  play([this](Agent& agent) -> asio::awaitable<void> {
    const auto stream = co_await welcome();
    assign(*stream, 0);
    co_await next<wire::Ready>(*stream);
    for (int i = 0; i < 100 && renderer.active == 0; ++i) co_await pause(5ms);
    agent.drain("asked to");
    co_await next<wire::Drain>(*stream);
    co_await next<wire::Bye>(*stream);
  });
  EXPECT_EQ(exit_code, 0);
}

TEST_F(AgentTest, a_drain_without_a_coordinator_ends_soon) {
  const AgentSettings nobody = settings();
  acceptor.close();
  Agent agent(io, nobody, renderer);
  asio::co_spawn(io, agent.run(), [&](std::exception_ptr, int code) { exit_code = code; });
  asio::steady_timer timer(io, 50ms);
  timer.async_wait([&](auto) { agent.drain("asked to"); });
  const auto end = std::chrono::steady_clock::now() + 10s;
  while (!exit_code && std::chrono::steady_clock::now() < end) io.run_one_for(50ms);
  EXPECT_EQ(exit_code, 0);
}

TEST_F(AgentTest, a_refused_token_ends_it_with_4) {
  play([this](Agent&) -> asio::awaitable<void> {
    asio::ip::tcp::socket socket = co_await acceptor.async_accept(asio::use_awaitable);
    FramedStream stream(std::move(socket));
    co_await stream.receive(5s);
    wire::Refused refused;
    refused.code = "token";
    refused.reason = "not the token";
    stream.send(refused);
    co_await stream.finish(5s);
    for (int i = 0; i < 100 && !exit_code; ++i) co_await pause(5ms);
  });
  EXPECT_EQ(exit_code, 4);
}

TEST_F(AgentTest, a_full_coordinator_is_tried_again) {
  play([this](Agent&) -> asio::awaitable<void> {
    {
      asio::ip::tcp::socket socket = co_await acceptor.async_accept(asio::use_awaitable);
      FramedStream stream(std::move(socket));
      co_await stream.receive(5s);
      wire::Refused refused;
      refused.code = "full";
      refused.reason = "later";
      stream.send(refused);
      co_await stream.finish(5s);
    }
    const auto stream = co_await welcome();
    EXPECT_TRUE(stream->is_open());
  });
}

TEST_F(AgentTest, a_scene_that_cannot_be_built_is_said_with_its_place) {
  renderer.prepare_error = "scene.json:3:1: unknown material \"gold\"";
  play([this](Agent&) -> asio::awaitable<void> {
    const auto stream = co_await welcome();
    assign(*stream, 0);
    const wire::Failed failed = co_await next<wire::Failed>(*stream);
    EXPECT_EQ(failed.code, "scene");
    EXPECT_FALSE(failed.lease);
    EXPECT_THAT(failed.reason, testing::HasSubstr("unknown material \"gold\""));
  });
}

TEST_F(AgentTest, blobs_that_cannot_be_fetched_are_said) {
  bundle = digest_of("nowhere");
  plan = JobPlan(test_spec(bundle));
  play([this](Agent&) -> asio::awaitable<void> {
    const auto stream = co_await welcome();
    assign(*stream, 0);
    const wire::Failed failed = co_await next<wire::Failed>(*stream);
    EXPECT_EQ(failed.code, "fetch");
    EXPECT_THAT(failed.reason, testing::HasSubstr(bundle.hex()));
  });
}

TEST_F(AgentTest, a_revoked_task_is_stopped_and_not_delivered) {
  renderer.hold = true;
  play([this](Agent&) -> asio::awaitable<void> {
    const auto stream = co_await welcome();
    const LeaseId lease = assign(*stream, 0);
    co_await next<wire::Ready>(*stream);
    for (int i = 0; i < 100 && renderer.active == 0; ++i) co_await pause(5ms);
    wire::Revoke revoke;
    revoke.leases = {lease};
    stream->send(revoke);
    for (int i = 0; i < 200 && renderer.active > 0; ++i) co_await pause(5ms);
    EXPECT_EQ(renderer.active, 0);
    renderer.hold = false;
    const LeaseId other = assign(*stream, 1, 0, false);
    const wire::Result result = co_await next<wire::Result>(*stream);
    EXPECT_EQ(result.lease, other);
    stream->send(wire::Accepted{.lease = other});
  });
}

}  // namespace
}  // namespace tessera::agent
