#include "common/net/http_client.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <fstream>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "common/base/error.hpp"

namespace tessera::net {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using namespace std::chrono_literals;
using testing::HasSubstr;

/// Answers each request with what `answer` gives for it; an empty answer closes the connection. One
/// connection at a time.
class TestServer {
 public:
  using Answer = std::function<std::string(const std::string& request)>;
  explicit TestServer(Answer answer) : answer_(std::move(answer)), thread_([this] { serve(); }) {}
  ~TestServer() {
    stopping_ = true;
    asio::io_context io;
    tcp::socket(io).connect(acceptor_.local_endpoint());
    thread_.join();
  }
  std::string url() {
    return "http://127.0.0.1:" + std::to_string(acceptor_.local_endpoint().port());
  }
  std::atomic<int> connections = 0;

 private:
  void serve() {
    while (true) {
      tcp::socket socket = acceptor_.accept();
      if (stopping_) return;
      ++connections;
      boost::system::error_code error;
      std::string buffer;
      while (!error && !stopping_) {
        const std::size_t head =
            asio::read_until(socket, asio::dynamic_buffer(buffer), "\r\n\r\n", error);
        if (error) break;
        std::size_t length = 0;
        if (const std::size_t at = buffer.find("Content-Length: "); at < head)
          length = std::stoul(buffer.substr(at + 16));
        while (!error && buffer.size() < head + length) {
          char more[4096];
          const std::size_t got = socket.read_some(asio::buffer(more), error);
          buffer.append(more, got);
        }
        const std::string out = answer_(buffer.substr(0, head + length));
        buffer.erase(0, head + length);
        if (out.empty()) break;
        asio::write(socket, asio::buffer(out), error);
        if (out.find("Connection: close") != std::string::npos) break;
      }
    }
  }
  Answer answer_;
  asio::io_context io_;
  tcp::acceptor acceptor_{io_, tcp::endpoint(asio::ip::address_v4::loopback(), 0)};
  std::atomic<bool> stopping_ = false;
  std::thread thread_;
};

std::string ok(const std::string& body, const std::string& extra = "") {
  return "HTTP/1.1 200 OK\r\n" + extra + "Content-Length: " + std::to_string(body.size()) +
         "\r\n\r\n" + body;
}

template <class T>
T run(asio::io_context& io, asio::awaitable<T> work) {
  std::optional<T> value;
  std::exception_ptr failure;
  asio::co_spawn(io, std::move(work), [&](std::exception_ptr error, T got) {
    failure = error;
    if (!error) value = std::move(got);
  });
  io.restart();
  io.run_for(20s);
  if (failure) std::rethrow_exception(failure);
  if (!value) throw std::runtime_error("the request did not end");
  return std::move(*value);
}
void run(asio::io_context& io, asio::awaitable<void> work) {
  std::exception_ptr failure;
  asio::co_spawn(io, std::move(work), [&](std::exception_ptr error) { failure = error; });
  io.restart();
  io.run_for(20s);
  if (failure) std::rethrow_exception(failure);
}

Error error_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "no error";
  return Error(ErrorKind::failed, "no error");
}

TEST(HttpClient, a_request_carries_host_token_and_body_and_the_answer_comes_back) {
  std::string seen;
  TestServer server([&](const std::string& request) {
    seen = request;
    return ok("{\"id\":1}", "X-Kind: json\r\n");
  });
  asio::io_context io;
  HttpClient client(io.get_executor(), server.url(), "secret");
  const HttpResponse response =
      run(io, client.send({.method = "POST",
                           .target = "/v1/jobs?x=1",
                           .headers = {{"Content-Type", "application/json"}},
                           .body = "hello"}));
  EXPECT_EQ(response.status, 200);
  EXPECT_EQ(response.body, "{\"id\":1}");
  EXPECT_EQ(response.header("x-kind"), "json");
  EXPECT_EQ(response.header("none"), "");
  EXPECT_THAT(seen, testing::StartsWith("POST /v1/jobs?x=1 HTTP/1.1\r\n"));
  EXPECT_THAT(seen, HasSubstr("Authorization: Bearer secret\r\n"));
  EXPECT_THAT(seen, HasSubstr("Host: " + server.url().substr(7) + "\r\n"));
  EXPECT_THAT(seen, HasSubstr("Content-Length: 5\r\n"));
  EXPECT_THAT(seen, testing::EndsWith("\r\n\r\nhello"));
}

TEST(HttpClient, one_connection_serves_many_requests) {
  TestServer server([](const std::string&) { return ok("x"); });
  asio::io_context io;
  HttpClient client(io.get_executor(), server.url(), "");
  for (int i = 0; i < 5; ++i) EXPECT_EQ(run(io, client.send({.target = "/"})).body, "x");
  EXPECT_EQ(server.connections, 1);
}

TEST(HttpClient, a_kept_connection_that_the_server_closed_is_made_anew) {
  std::atomic<int> requests = 0;
  TestServer server([&](const std::string&) { return ++requests == 2 ? std::string() : ok("x"); });
  asio::io_context io;
  HttpClient client(io.get_executor(), server.url(), "");
  EXPECT_EQ(run(io, client.send({})).body, "x");
  EXPECT_EQ(run(io, client.send({})).body, "x");
  EXPECT_EQ(requests, 3);
}

TEST(HttpClient, a_post_is_never_sent_twice) {
  std::atomic<int> posts = 0;
  TestServer server([&](const std::string& request) {
    if (request.starts_with("POST")) return ++posts, std::string();
    return ok("x");
  });
  asio::io_context io;
  HttpClient client(io.get_executor(), server.url(), "");
  run(io, client.send({}));
  const Error error = error_of([&] { run(io, client.send({.method = "POST"})); });
  EXPECT_EQ(error.kind(), ErrorKind::unreachable);
  EXPECT_EQ(posts, 1);
}

TEST(HttpClient, statuses_become_errors_with_the_problems_detail) {
  const std::pair<int, ErrorKind> cases[] = {
      {400, ErrorKind::bad_input}, {401, ErrorKind::refused},  {403, ErrorKind::refused},
      {404, ErrorKind::not_found}, {409, ErrorKind::conflict}, {413, ErrorKind::too_large},
      {422, ErrorKind::bad_input}, {500, ErrorKind::failed}};
  for (const auto& [status, kind] : cases) {
    TestServer server([status = status](const std::string&) {
      const std::string body = "{\"title\":\"no\",\"detail\":\"the film is too wide\"}";
      return "HTTP/1.1 " + std::to_string(status) +
             " X\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body;
    });
    asio::io_context io;
    HttpClient client(io.get_executor(), server.url(), "");
    const Error error = error_of([&] { run(io, client.send({})); });
    EXPECT_EQ(error.kind(), kind) << status;
    EXPECT_STREQ(error.what(), "the film is too wide");
    EXPECT_EQ(run(io, client.send({.errors_throw = false})).status, status);
  }
}

TEST(HttpClient, a_problem_says_which_key_of_the_request_was_wrong) {
  TestServer server([](const std::string&) {
    const std::string body =
        R"({"title":"no","detail":"expected more samples","place":{"key":"samples"}})";
    return "HTTP/1.1 400 X\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body;
  });
  asio::io_context io;
  HttpClient client(io.get_executor(), server.url(), "");
  const Error error = error_of([&] { run(io, client.send({})); });
  EXPECT_EQ(error.place().key, "samples");
  EXPECT_STREQ(error.what(), "samples: expected more samples");
}

TEST(HttpClient, head_has_no_body_though_a_length_is_said) {
  TestServer server(
      [](const std::string&) { return "HTTP/1.1 200 OK\r\nContent-Length: 500\r\n\r\n"; });
  asio::io_context io;
  HttpClient client(io.get_executor(), server.url(), "");
  const HttpResponse response = run(io, client.send({.method = "HEAD"}));
  EXPECT_EQ(response.header("Content-Length"), "500");
  EXPECT_EQ(response.body, "");
}

TEST(HttpClient, an_answer_beyond_the_limit_is_too_large_and_a_download_takes_it) {
  const std::string big(300000, 'b');
  TestServer server([&](const std::string&) { return ok(big); });
  asio::io_context io;
  HttpClient client(io.get_executor(), server.url(), "");
  EXPECT_EQ(error_of([&] { run(io, client.send({.response_most = 1000})); }).kind(),
            ErrorKind::too_large);
  std::size_t got = 0;
  run(io, client.download({.response_most = 1000},
                          [&](std::span<const std::byte> bytes) { got += bytes.size(); }));
  EXPECT_EQ(got, big.size());
}

TEST(HttpClient, a_range_of_a_file_is_sent) {
  const std::string path = testing::TempDir() + "/http_client_range";
  std::ofstream(path) << std::string(100000, 'a') << std::string(150000, 'b');
  std::string seen;
  TestServer server([&](const std::string& request) {
    seen = request;
    return ok("");
  });
  asio::io_context io;
  HttpClient client(io.get_executor(), server.url(), "");
  const HttpRequest request{.method = "PUT",
                            .target = "/f",
                            .file = FileRange{.file = path, .offset = 99999, .size = 150000}};
  run(io, client.send(request));
  EXPECT_EQ(seen.substr(seen.find("\r\n\r\n") + 4), "a" + std::string(149999, 'b'));
  std::filesystem::remove(path);
  EXPECT_EQ(error_of([&] { run(io, client.send(request)); }).kind(), ErrorKind::failed);
}

TEST(HttpClient, a_server_that_does_not_answer_is_unreachable_in_time) {
  asio::io_context io;
  tcp::acceptor mute(io, tcp::endpoint(asio::ip::address_v4::loopback(), 0));
  HttpClient client(io.get_executor(),
                    "http://127.0.0.1:" + std::to_string(mute.local_endpoint().port()), "");
  const auto begin = std::chrono::steady_clock::now();
  const Error error = error_of([&] { run(io, client.send({.time = 100ms})); });
  EXPECT_EQ(error.kind(), ErrorKind::unreachable);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 5s);
  const std::uint16_t port = mute.local_endpoint().port();
  mute.close();
  HttpClient nobody(io.get_executor(), "http://127.0.0.1:" + std::to_string(port), "");
  EXPECT_EQ(error_of([&] { run(io, nobody.send({})); }).kind(), ErrorKind::unreachable);
}

TEST(HttpClient, an_answer_that_is_not_http_fails) {
  TestServer server([](const std::string&) { return "TSRA nonsense\r\n\r\n"; });
  asio::io_context io;
  HttpClient client(io.get_executor(), server.url(), "");
  EXPECT_EQ(error_of([&] { run(io, client.send({})); }).kind(), ErrorKind::failed);
}

TEST(HttpClient, cancel_ends_what_is_under_way) {
  asio::io_context io;
  tcp::acceptor mute(io, tcp::endpoint(asio::ip::address_v4::loopback(), 0));
  HttpClient client(io.get_executor(),
                    "http://127.0.0.1:" + std::to_string(mute.local_endpoint().port()), "");
  asio::steady_timer timer(io, 50ms);
  timer.async_wait([&](auto) { client.cancel(); });
  EXPECT_THAT(error_of([&] { run(io, client.send({})); }).what(), HasSubstr("cancelled"));
}

TEST(HttpClient, urls_that_are_none_are_refused) {
  asio::io_context io;
  for (const char* url : {"", "127.0.0.1:8420", "https://a", "http://", "http://a:b"})
    EXPECT_THROW(HttpClient(io.get_executor(), url, ""), Error) << url;
}

TEST(HttpClient, events_come_one_by_one_until_the_listener_has_enough) {
  TestServer server([](const std::string& request) -> std::string {
    EXPECT_THAT(request, HasSubstr("Last-Event-ID: 41\r\n"));
    return "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nConnection: close\r\n\r\n"
           ": hello\n\nid: 42\nevent: job\ndata: {\"a\":\ndata: 1}\n\ndata: second\n\ndata: "
           "third\n\n";
  });
  asio::io_context io;
  HttpClient client(io.get_executor(), server.url(), "");
  std::vector<ServerEvent> events;
  run(io, client.events("/v1/events", "41", 5s, [&](const ServerEvent& event) {
    events.push_back(event);
    return events.size() < 2;
  }));
  ASSERT_EQ(events.size(), 2U);
  EXPECT_EQ(events[0].type, "job");
  EXPECT_EQ(events[0].id, "42");
  EXPECT_EQ(events[0].data, "{\"a\":\n1}");
  EXPECT_EQ(events[1].type, "message");
  EXPECT_EQ(events[1].data, "second");
}

TEST(HttpClient, a_stream_of_events_that_is_refused_is_an_error) {
  TestServer server(
      [](const std::string&) { return "HTTP/1.1 404 No\r\nContent-Length: 0\r\n\r\n"; });
  asio::io_context io;
  HttpClient client(io.get_executor(), server.url(), "");
  EXPECT_EQ(error_of([&] {
              run(io, client.events("/x", "", 5s, [](const ServerEvent&) { return true; }));
            }).kind(),
            ErrorKind::not_found);
}

TEST(EventParser, events_are_the_same_wherever_the_bytes_are_cut_and_however_lines_end) {
  for (const std::string newline : {"\n", "\r\n", "\r"}) {
    const std::string text = "\xef\xbb\xbf: c" + newline + "event:a" + newline + "data: 1" +
                             newline + "data" + newline + newline + "id: 7" + newline + "data: 2" +
                             newline + newline + newline + "data: lost";
    for (std::size_t cut = 0; cut <= text.size(); ++cut) {
      EventParser parser;
      std::vector<ServerEvent> events = parser.feed(text.substr(0, cut));
      for (ServerEvent& event : parser.feed(text.substr(cut))) events.push_back(std::move(event));
      ASSERT_EQ(events.size(), 2U) << cut;
      EXPECT_EQ(events[0].type, "a");
      EXPECT_EQ(events[0].data, "1\n");
      EXPECT_EQ(events[1].type, "message");
      EXPECT_EQ(events[1].data, "2");
      EXPECT_EQ(events[1].id, "7");
    }
  }
}

TEST(EventParser, an_event_without_end_is_too_large_in_the_end) {
  EventParser parser;
  const std::string line(limits::MiB, 'x');
  EXPECT_THROW(for (int i = 0; i < 5; ++i) parser.feed(line), Error);
}

TEST(Url, all_but_unreserved_characters_are_encoded) {
  EXPECT_EQ(url_encoded("a/b c~é"), "a%2Fb%20c~%C3%A9");
}

}  // namespace
}  // namespace tessera::net
