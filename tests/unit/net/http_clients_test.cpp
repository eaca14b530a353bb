#include "common/net/http_clients.hpp"

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <chrono>
#include <optional>
#include <string>

#include "common/base/error.hpp"

namespace tessera::net {
namespace {

namespace asio = boost::asio;
using namespace std::chrono_literals;

/// A port that takes connections and never answers.
class SilentPort {
 public:
  explicit SilentPort(asio::io_context& io)
      : acceptor_(io, {asio::ip::address_v4::loopback(), 0}) {}
  std::string url() {
    return "http://127.0.0.1:" + std::to_string(acceptor_.local_endpoint().port());
  }

 private:
  asio::ip::tcp::acceptor acceptor_;
};

struct HttpClientsTest : testing::Test {
  asio::io_context io{1};
  SilentPort port{io};
  HttpClients clients{io.get_executor(), port.url(), "", 3};
  int begun = 0, ended = 0;
  std::string error;

  asio::awaitable<void> ask(HttpClient& client) {
    HttpRequest request;
    co_await client.send(std::move(request));
  }
  asio::awaitable<void> rest() { co_await clients.pause(1h); }
  asio::awaitable<void> fail() {
    co_await clients.pause(1ms);
    throw Error(ErrorKind::conflict, "the first");
  }
  asio::awaitable<void> end() {
    ++ended;
    co_return;
  }
  /// Until all have ended.
  void run(HttpClients::Task task) {
    clients.run(std::move(task), [this](const std::exception_ptr& thrown) {
      try {
        if (thrown) std::rethrow_exception(thrown);
        error = "none";
      } catch (const Error& said) {
        error = said.what();
      }
    });
    io.restart();
    io.run_for(20s);
  }
};

TEST_F(HttpClientsTest, each_connection_runs_the_task_once) {
  run([this](HttpClient&) { return end(); });
  EXPECT_EQ(ended, 3);
  EXPECT_EQ(error, "none");
}

TEST_F(HttpClientsTest, the_first_error_ends_what_the_others_wait_for) {
  run([this](HttpClient& client) {
    ++begun;
    return begun == 1 ? ask(client) : begun == 2 ? rest() : fail();
  });
  EXPECT_EQ(begun, 3);
  EXPECT_EQ(error, "the first");
  EXPECT_TRUE(clients.cancelled());
  run([this](HttpClient&) { return end(); });
  EXPECT_EQ(error, "none") << "they may run again";
}

TEST_F(HttpClientsTest, a_cancel_ends_all) {
  asio::steady_timer soon(io, 1ms);
  soon.async_wait([this](const boost::system::error_code&) { clients.cancel(); });
  run([this](HttpClient& client) { return ++begun == 1 ? ask(client) : rest(); });
  EXPECT_EQ(error, "cancelled");
}

}  // namespace
}  // namespace tessera::net
