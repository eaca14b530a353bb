#include "common/net/framed_stream.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <functional>
#include <string>

#include "common/base/error.hpp"
#include "common/wire/codec.hpp"
#include "common/wire/framing.hpp"

namespace tessera::net {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using namespace std::chrono_literals;
using testing::HasSubstr;

/// Two ends of one loopback connection, on one thread.
class FramedStreamTest : public testing::Test {
 protected:
  asio::io_context io;
  tcp::acceptor acceptor = listen(io.get_executor(), {"127.0.0.1", 0});

  /// A raw socket that is connected to what accept() gives.
  tcp::socket raw() {
    tcp::socket socket(io);
    socket.connect(acceptor.local_endpoint());
    return socket;
  }
  FramedStream accepted(StreamSettings settings = {}) {
    return FramedStream(acceptor.accept(), settings);
  }

  void run(std::function<asio::awaitable<void>()> body) {
    std::exception_ptr failure;
    bool done = false;
    asio::co_spawn(io, std::move(body), [&](std::exception_ptr error) {
      failure = error;
      done = true;
    });
    io.restart();
    const auto end = std::chrono::steady_clock::now() + 20s;
    while (!done && std::chrono::steady_clock::now() < end) io.run_one_for(100ms);
    ASSERT_TRUE(done) << "the coroutine did not end";
    if (failure) std::rethrow_exception(failure);
  }

  /// The error of the next receive(), or "" if a message came, "nothing" if none did.
  asio::awaitable<std::string> receive_error(FramedStream& stream, Duration wait = 5s) {
    try {
      const std::optional<Incoming> incoming = co_await stream.receive(wait);
      co_return incoming ? "" : "nothing";
    } catch (const Error& error) {
      co_return error.what();
    }
  }
  static void write(tcp::socket& socket, std::string_view text) {
    asio::write(socket, asio::buffer(text));
  }
};

wire::Result result_numbered(std::uint64_t number) {
  return {.lease = {.epoch = 1, .number = number}, .job = 1};
}

std::shared_ptr<const std::vector<std::byte>> body_of(std::size_t size) {
  auto body = std::make_shared<std::vector<std::byte>>(size);
  for (std::size_t i = 0; i < size; ++i) (*body)[i] = static_cast<std::byte>(i * 7 & 0xffU);
  return body;
}

TEST_F(FramedStreamTest, messages_and_bodies_arrive_as_they_were_sent) {
  run([&]() -> asio::awaitable<void> {
    const Address address{"127.0.0.1", acceptor.local_endpoint().port()};
    FramedStream a = co_await FramedStream::connect(io.get_executor(), address, 5s);
    FramedStream b = accepted();
    b.welcomed();
    const auto body = body_of(300000);
    a.send(wire::Ready{.job = 7});
    a.send(result_numbered(5), body);
    const std::optional<Incoming> ready = co_await b.receive(5s);
    const std::optional<Incoming> result = co_await b.receive(5s);
    EXPECT_TRUE(ready && result);
    if (!ready || !result) co_return;
    EXPECT_EQ(std::get<wire::Ready>(ready->message).job, 7U);
    EXPECT_EQ(std::get<wire::Result>(result->message).lease.number, 5U);
    EXPECT_EQ(result->body, *body);
    EXPECT_EQ(a.peer(), b.local());
    const bool flushed = co_await a.flush(5s);
    EXPECT_TRUE(flushed);
    EXPECT_EQ(a.queued(), 0U);
  });
}

TEST_F(FramedStreamTest, control_messages_overtake_bodies_and_bye_does_not) {
  run([&]() -> asio::awaitable<void> {
    tcp::socket socket = raw();
    FramedStream b = accepted({.queue_bytes = 64 * limits::MiB});
    FramedStream a(std::move(socket), {.queue_bytes = 64 * limits::MiB});
    b.welcomed();
    a.send(result_numbered(1), body_of(8 * limits::MiB));
    a.send(result_numbered(2), body_of(8 * limits::MiB));
    a.send(wire::Bye{.reason = "done"});
    a.send(wire::Progress{});
    std::string order;
    for (int i = 0; i < 4; ++i) {
      const std::optional<Incoming> incoming = co_await b.receive(10s);
      EXPECT_TRUE(incoming);
      if (!incoming) co_return;
      order += std::string(wire::name_of(wire::type_of(incoming->message))) + " ";
    }
    EXPECT_EQ(order, "progress result result bye ");
  });
}

TEST_F(FramedStreamTest, receive_gives_nothing_after_its_wait_and_keeps_what_came) {
  run([&]() -> asio::awaitable<void> {
    tcp::socket socket = raw();
    FramedStream stream = accepted();
    const auto bytes = wire::frame_bytes(6, "{\"job\":9}");
    asio::write(socket, asio::buffer(bytes.data(), 20));
    const std::string first = co_await receive_error(stream, 50ms);
    EXPECT_EQ(first, "nothing");
    asio::write(socket, asio::buffer(bytes.data() + 20, bytes.size() - 20));
    const std::optional<Incoming> incoming = co_await stream.receive(5s);
    EXPECT_TRUE(incoming && std::get<wire::Ready>(incoming->message).job == 9);
  });
}

TEST_F(FramedStreamTest, half_a_frame_and_then_silence_is_cut_off) {
  run([&]() -> asio::awaitable<void> {
    tcp::socket socket = raw();
    FramedStream stream = accepted({.frame_time = 100ms});
    write(socket, "TSRA");
    const auto begin = std::chrono::steady_clock::now();
    const std::string error = co_await receive_error(stream, 10s);
    EXPECT_THAT(error, HasSubstr("part of a frame"));
    EXPECT_LT(std::chrono::steady_clock::now() - begin, 5s);
    EXPECT_FALSE(stream.is_open());
  });
}

TEST_F(FramedStreamTest, silence_between_frames_is_not_cut_off) {
  run([&]() -> asio::awaitable<void> {
    tcp::socket socket = raw();
    FramedStream stream = accepted({.frame_time = 20ms});
    const std::string error = co_await receive_error(stream, 200ms);
    EXPECT_EQ(error, "nothing");
    EXPECT_TRUE(stream.is_open());
  });
}

TEST_F(FramedStreamTest, strangers_are_told_apart) {
  run([&]() -> asio::awaitable<void> {
    const std::pair<std::string, std::string> cases[] = {
        {"GET / HTTP/1.1\r\nHost: a\r\n\r\n", "HTTP"},
        {"some garbage", "TSRA"},
        {std::string("TSRA\x09\x00", 6), "version 9"}};
    for (const auto& [bytes, expected] : cases) {
      tcp::socket socket = raw();
      FramedStream stream = accepted();
      write(socket, bytes);
      const std::string error = co_await receive_error(stream);
      EXPECT_THAT(error, HasSubstr(expected));
    }
  });
}

TEST_F(FramedStreamTest, a_header_that_does_not_decode_is_an_error_that_names_the_key) {
  run([&]() -> asio::awaitable<void> {
    tcp::socket socket = raw();
    FramedStream stream = accepted();
    const auto bytes = wire::frame_bytes(6, "{\"job\":-1}");
    asio::write(socket, asio::buffer(bytes));
    const std::string error = co_await receive_error(stream);
    EXPECT_THAT(error, HasSubstr("ready.job"));
  });
}

TEST_F(FramedStreamTest, every_piece_of_bytes_is_a_sign_of_life) {
  run([&]() -> asio::awaitable<void> {
    tcp::socket socket = raw();
    FramedStream stream = accepted();
    int signs = 0;
    stream.on_bytes([&signs] { ++signs; });
    write(socket, "TS");
    co_await receive_error(stream, 50ms);
    EXPECT_EQ(signs, 1);
    write(socket, "RA");
    co_await receive_error(stream, 50ms);
    EXPECT_EQ(signs, 2);
    co_await receive_error(stream, 50ms);
    EXPECT_EQ(signs, 2);
  });
}

TEST_F(FramedStreamTest, the_end_of_the_other_side_is_an_error_that_says_so) {
  run([&]() -> asio::awaitable<void> {
    tcp::socket socket = raw();
    FramedStream stream = accepted();
    socket.close();
    const std::string error = co_await receive_error(stream);
    EXPECT_THAT(error, HasSubstr("closed the connection"));
    stream.send(wire::Ready{.job = 1});  // does nothing
    EXPECT_EQ(stream.queued(), 0U);
  });
}

TEST_F(FramedStreamTest, close_ends_a_receive_with_its_reason) {
  run([&]() -> asio::awaitable<void> {
    tcp::socket socket = raw();
    FramedStream stream = accepted();
    asio::steady_timer timer(io, 30ms);
    timer.async_wait([&](auto) { stream.close("enough"); });
    const std::string error = co_await receive_error(stream, 10s);
    EXPECT_EQ(error, "enough");
  });
}

TEST_F(FramedStreamTest, a_peer_that_does_not_read_overflows_the_queue_and_is_closed) {
  run([&]() -> asio::awaitable<void> {
    tcp::socket socket = raw();
    FramedStream stream = accepted({.queue_bytes = 4 * limits::MiB});
    for (int i = 0; i < 6 && stream.is_open(); ++i)
      stream.send(result_numbered(1), body_of(limits::MiB));
    EXPECT_FALSE(stream.is_open());
    const std::string error = co_await receive_error(stream);
    EXPECT_THAT(error, HasSubstr("does not read"));
  });
}

TEST_F(FramedStreamTest, a_write_that_takes_too_long_closes_the_stream) {
  run([&]() -> asio::awaitable<void> {
    tcp::socket socket = raw();
    FramedStream stream = accepted({.queue_bytes = 128 * limits::MiB, .write_time = 100ms});
    stream.send(result_numbered(1), body_of(60 * limits::MiB));
    const std::string error = co_await receive_error(stream, 10s);
    EXPECT_FALSE(stream.is_open()) << error;
    const bool flushed = co_await stream.flush(1s);
    EXPECT_FALSE(flushed);
  });
}

TEST_F(FramedStreamTest, finish_delivers_the_last_message_though_the_other_side_still_sends) {
  run([&]() -> asio::awaitable<void> {
    tcp::socket socket = raw();
    FramedStream stream = accepted();
    asio::write(socket, asio::buffer(std::string(100000, 'x')));  // never read by the stream
    stream.send(wire::Refused{.code = "version", .reason = "another version"});
    bool finished = false;
    asio::co_spawn(io, stream.finish(5s), [&](std::exception_ptr) { finished = true; });
    wire::FrameReader reader;
    std::string code;
    std::vector<std::byte> buffer(4096);
    while (code.empty()) {
      boost::system::error_code error;
      const std::size_t got =
          co_await socket.async_read_some(asio::buffer(buffer), asio::use_awaitable);
      std::span<const std::byte> bytes(buffer.data(), got);
      if (const auto frame = reader.read(bytes))
        code = std::get<wire::Refused>(wire::decode(frame->type, frame->header)).code;
    }
    EXPECT_EQ(code, "version");
    socket.close();
    asio::steady_timer timer(io);
    for (int i = 0; i < 100 && !finished; ++i) {
      timer.expires_after(10ms);
      co_await timer.async_wait(asio::use_awaitable);
    }
    EXPECT_TRUE(finished);
  });
}

TEST_F(FramedStreamTest, a_long_revoke_goes_in_several_messages) {
  run([&]() -> asio::awaitable<void> {
    tcp::socket socket = raw();
    FramedStream b = accepted();
    FramedStream a(std::move(socket));
    b.welcomed();
    wire::Revoke revoke;
    for (std::uint64_t i = 0; i < 10000; ++i) revoke.leases.push_back({.epoch = 1, .number = i});
    a.send(revoke);
    std::uint64_t next = 0;
    while (next < 10000) {
      const std::optional<Incoming> incoming = co_await b.receive(5s);
      EXPECT_TRUE(incoming);
      if (!incoming) co_return;
      for (const LeaseId& lease : std::get<wire::Revoke>(incoming->message).leases)
        EXPECT_EQ(lease.number, next++);
    }
  });
}

TEST_F(FramedStreamTest, where_nobody_listens_the_error_names_the_address) {
  const std::uint16_t port = acceptor.local_endpoint().port();
  acceptor.close();
  run([&]() -> asio::awaitable<void> {
    std::string what;
    const Address address{"127.0.0.1", port};
    try {
      co_await FramedStream::connect(io.get_executor(), address, 5s);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::unreachable);
      what = error.what();
    }
    EXPECT_THAT(what, HasSubstr(address.text()));
  });
}

TEST_F(FramedStreamTest, a_port_that_is_taken_cannot_be_listened_on) {
  const Address taken{"127.0.0.1", acceptor.local_endpoint().port()};
  EXPECT_THROW(listen(io.get_executor(), taken), Error);
}

}  // namespace
}  // namespace tessera::net
