#include <gmock/gmock.h>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>

#include "common/wire/codec.hpp"
#include "common/wire/framing.hpp"
#include "tests/unit/session/farm.hpp"

/// Peers that are no workers, or bad ones: each is told why and cut off, and the coordinator goes
/// on.
namespace tessera::server {
namespace {

using boost::asio::ip::tcp;
using testing::HasSubstr;
constexpr auto as_values = boost::asio::as_tuple(boost::asio::use_awaitable);

class Peers : public testing::Test {
 protected:
  void open(SessionSettings settings) {
    farm.run(farm.halt());
    farm.io.reset();
    farm.session_settings = std::move(settings);
    farm.start();
  }

  awaitable<tcp::socket> dial() {
    tcp::socket socket(*farm.io);
    const tcp::endpoint there(boost::asio::ip::make_address("127.0.0.1"), farm.listener->port());
    co_await socket.async_connect(there, boost::asio::use_awaitable);
    co_return socket;
  }

  /// Sends raw bytes and gives the messages that come back until the other side closes.
  awaitable<std::vector<wire::Message>> answer_to(std::string bytes) {
    tcp::socket socket = co_await dial();
    const auto buffer = boost::asio::buffer(bytes);
    co_await boost::asio::async_write(socket, buffer, as_values);
    wire::FrameReader reader;
    reader.welcomed();
    std::vector<wire::Message> messages;
    std::array<std::byte, 4096> piece{};
    for (;;) {
      const auto target = boost::asio::buffer(piece);
      const auto [error, count] = co_await socket.async_read_some(target, as_values);
      if (error) break;
      std::span<const std::byte> left(piece.data(), count);
      while (auto frame = reader.read(left))
        messages.push_back(wire::decode(frame->type, frame->header));
    }
    co_return messages;
  }

  /// The only answer must be a refusal.
  awaitable<wire::Refused> refusal_of(std::string bytes) {
    const auto messages = co_await answer_to(std::move(bytes));
    EXPECT_EQ(messages.size(), 1U);
    if (messages.empty() || !std::holds_alternative<wire::Refused>(messages[0]))
      co_return wire::Refused();
    co_return std::get<wire::Refused>(messages[0]);
  }

  static std::string frame_of(const wire::Message& message) {
    const wire::EncodedMessage encoded = wire::encode(message);
    const wire::OutFrame out = wire::first_frame(encoded.type, encoded.header, {});
    std::string bytes = out.head;
    for (const std::byte byte : out.crc) bytes += static_cast<char>(byte);
    return bytes;
  }
  static wire::Hello hello() {
    wire::Hello hello;
    hello.name = "peer";
    hello.identity = std::string(32, '9');
    hello.threads = 1;
    return hello;
  }

  /// Whatever came before: a good worker is welcomed.
  awaitable<void> expect_in_order() {
    ScriptedWorker good("good", '1');
    good.token = farm.session_settings.token;
    co_await good.connect(farm);
    EXPECT_GT(good.welcome.worker, 0U);
    good.leave();
  }
  awaitable<void> until_alone() {
    while (farm.listener->connections() > 0) co_await sleep_for(std::chrono::milliseconds(2));
  }

  Farm farm;
};

TEST_F(Peers, GarbageIsRefusedAsNoProtocol) {
  const auto scenario = [&]() -> awaitable<void> {
    const auto refused = co_await refusal_of(std::string(64, '\x07'));
    EXPECT_EQ(refused.code, "protocol");
    co_await until_alone();
    co_await expect_in_order();
  };
  farm.run(scenario());
}

TEST_F(Peers, HttpIsToldThatThisIsTheWorkersPort) {
  const auto scenario = [&]() -> awaitable<void> {
    const auto refused = co_await refusal_of("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
    EXPECT_EQ(refused.code, "protocol");
    EXPECT_THAT(refused.reason, HasSubstr("HTTP"));
    co_await expect_in_order();
  };
  farm.run(scenario());
}

TEST_F(Peers, AnotherVersionIsRefusedAsSuch) {
  const auto scenario = [&]() -> awaitable<void> {
    std::string bytes = frame_of(hello());
    bytes[4] = 9;
    const auto refused = co_await refusal_of(bytes);
    EXPECT_EQ(refused.code, "version");
    EXPECT_THAT(refused.reason, HasSubstr("9"));
    co_await expect_in_order();
  };
  farm.run(scenario());
}

TEST_F(Peers, HeaderBeyondTheLimitForStrangersIsRefusedBeforeItComes) {
  const auto scenario = [&]() -> awaitable<void> {
    std::string bytes = frame_of(hello()).substr(0, 16);
    bytes[8] = bytes[9] = bytes[10] = '\xff';
    const auto refused = co_await refusal_of(bytes);
    EXPECT_EQ(refused.code, "protocol");
    co_await expect_in_order();
  };
  farm.run(scenario());
}

TEST_F(Peers, WrongTokenIsRefused) {
  SessionSettings settings;
  settings.token = "right";
  open(settings);
  const auto scenario = [&]() -> awaitable<void> {
    wire::Hello wrong = hello();
    wrong.token = "wrong";
    EXPECT_EQ((co_await refusal_of(frame_of(wrong))).code, "token");
    EXPECT_EQ((co_await refusal_of(frame_of(hello()))).code, "token");
    EXPECT_TRUE(farm.coordinator->workers().empty());
    co_await expect_in_order();
  };
  farm.run(scenario());
}

TEST_F(Peers, AnythingBeforeHelloIsRefused) {
  const auto scenario = [&]() -> awaitable<void> {
    const auto refused = co_await refusal_of(frame_of(wire::Ready{1}));
    EXPECT_EQ(refused.code, "protocol");
    EXPECT_THAT(refused.reason, HasSubstr("expected hello"));
  };
  farm.run(scenario());
}

TEST_F(Peers, HalfAFrameAndThenSilenceIsCutOffWithinTheHandshake) {
  SessionSettings settings;
  settings.handshake_time = std::chrono::milliseconds(200);
  open(settings);
  const auto scenario = [&]() -> awaitable<void> {
    const auto began = std::chrono::steady_clock::now();
    const std::string half = frame_of(hello()).substr(0, 40);
    const auto refused = co_await refusal_of(half);
    EXPECT_EQ(refused.code, "protocol");
    EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(2));
    EXPECT_EQ((co_await refusal_of("")).code, "protocol");  // not a byte
    co_await until_alone();
    co_await expect_in_order();
  };
  farm.run(scenario());
}

TEST_F(Peers, SecondHelloEndsTheSessionWithAReason) {
  const auto scenario = [&]() -> awaitable<void> {
    const auto messages = co_await answer_to(frame_of(hello()) + frame_of(hello()));
    EXPECT_EQ(messages.size(), 2U);
    EXPECT_TRUE(std::holds_alternative<wire::Welcome>(messages.at(0)));
    EXPECT_THAT(std::get<wire::Refused>(messages.at(1)).reason,
                HasSubstr("does not send after hello"));
    co_await until_alone();
    EXPECT_TRUE(farm.coordinator->workers().empty());
  };
  farm.run(scenario());
}

TEST_F(Peers, MoreThanAreTakenAreToldThatItIsFull) {
  SessionSettings settings;
  settings.connections_max = 2;
  open(settings);
  const auto scenario = [&]() -> awaitable<void> {
    const tcp::socket one = co_await dial();
    tcp::socket two = co_await dial();
    while (farm.listener->connections() < 2) co_await sleep_for(std::chrono::milliseconds(1));
    EXPECT_EQ((co_await refusal_of("")).code, "full");
    two.close();
    while (farm.listener->connections() > 1) co_await sleep_for(std::chrono::milliseconds(1));
    co_await expect_in_order();
  };
  farm.run(scenario());
}

TEST_F(Peers, SameIdentityAgainTakesTheOlderConnectionsPlace) {
  ScriptedWorker older("older", '7');
  ScriptedWorker newer("newer", '7');
  const auto scenario = [&]() -> awaitable<void> {
    co_await older.connect(farm);
    co_await newer.connect(farm);
    co_await older.work([&] { return !older.ended.empty(); });
    EXPECT_NE(older.bye, "");
    while (farm.listener->connections() > 1) co_await sleep_for(std::chrono::milliseconds(1));
    EXPECT_EQ(farm.coordinator->workers().size(), 1U);
    EXPECT_EQ(farm.coordinator->workers().at(0).info.name, "newer");
  };
  farm.run(scenario());
}

TEST_F(Peers, WorkerThatDoesNotReadIsCutOffAndOthersDoItsWork) {
  JobId id = 0;
  const JobSpec spec = farm.spec(30, 20, 16, 5);
  ScriptedWorker good("good", '2');
  const auto scenario = [&]() -> awaitable<void> {
    tcp::socket deaf = co_await dial();
    const std::string first = frame_of(hello());
    const auto buffer = boost::asio::buffer(first);
    co_await boost::asio::async_write(deaf, buffer, boost::asio::use_awaitable);
    while (farm.coordinator->workers().empty()) co_await sleep_for(std::chrono::milliseconds(1));
    id = co_await farm.coordinator->submit(spec);
    co_await good.connect(farm);
    // It neither reads nor speaks: silent for 4 s, its leases are out again.
    co_await good.work([&] { return farm.coordinator->job(id)->view.state == "done"; });
    while (farm.coordinator->workers().size() > 1) co_await sleep_for(std::chrono::milliseconds(5));
  };
  const auto began = std::chrono::steady_clock::now();
  farm.run(scenario());
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(9));
}

TEST_F(Peers, StopSaysByeToWorkersAndWaitsForNobody) {
  ScriptedWorker worker("told", '3');
  const auto scenario = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    const tcp::socket silent = co_await dial();
    const auto working = farm.go(worker.work([] { return false; }));
    const auto began = std::chrono::steady_clock::now();
    co_await farm.halt();
    EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(3));
    while (!*working) co_await sleep_for(std::chrono::milliseconds(1));
    EXPECT_EQ(worker.bye, "the coordinator stops");
  };
  farm.run(scenario());
}

}  // namespace
}  // namespace tessera::server
