#include "server/session/listener.hpp"

#include <algorithm>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <vector>

#include "common/base/log.hpp"
#include "common/net/framed_stream.hpp"
#include "server/session/session.hpp"

namespace tessera::server {

namespace {

using boost::asio::awaitable;
using boost::asio::ip::tcp;

constexpr auto as_values = boost::asio::as_tuple(boost::asio::use_awaitable);

/// Beyond connections_max so many more are told why they are refused; others are closed without a
/// word.
constexpr std::size_t refusals_most = 64;

class Listener : public WorkerListener {
 public:
  Listener(const boost::asio::any_io_executor& executor, Coordinator& coordinator,
           SessionSettings settings)
      : executor_(executor),
        coordinator_(coordinator),
        settings_(std::move(settings)),
        acceptor_(net::listen(executor, net::Address{settings_.address, settings_.port})),
        pause_(executor),
        all_ended_(executor, boost::asio::steady_timer::time_point::max()) {
    port_ = acceptor_.local_endpoint().port();
    start(accept_loop());
  }

  [[nodiscard]] std::uint16_t port() const override { return port_; }

  [[nodiscard]] std::size_t connections() const override {
    return static_cast<std::size_t>(std::count_if(
        sessions_.begin(), sessions_.end(), [](const auto& weak) { return !weak.expired(); }));
  }

  awaitable<void> stop() override {
    stopping_ = true;
    boost::system::error_code ignored;
    acceptor_.close(ignored);
    pause_.cancel();
    for (const auto& weak : sessions_)
      if (const auto session = weak.lock()) session->stop("the coordinator stops");
    while (running_ > 0) co_await all_ended_.async_wait(as_values);
  }

 private:
  /// Every coroutine of the listener and its sessions is started and counted here.
  void start(awaitable<void> coroutine) {
    ++running_;
    boost::asio::co_spawn(executor_, std::move(coroutine), [this](const std::exception_ptr& error) {
      try {
        if (error) std::rethrow_exception(error);
      } catch (const std::exception& unexpected) {
        log::error("workers' port: {}", unexpected.what());
      }
      if (--running_ == 0) all_ended_.cancel();
    });
  }

  awaitable<void> accept_loop() {
    while (!stopping_) {
      auto [error, socket] = co_await acceptor_.async_accept(as_values);
      if (stopping_) break;
      if (error) {
        // Too many open files, or the peer left already: others may still get through, later.
        log::warn("workers' port: a connection could not be accepted: {}", error.message());
        pause_.expires_after(std::chrono::milliseconds(100));
        co_await pause_.async_wait(as_values);
        continue;
      }
      admit(std::move(socket));
    }
  }

  void admit(tcp::socket socket) {
    std::erase_if(sessions_, [](const auto& weak) { return weak.expired(); });
    const bool full = sessions_.size() >= settings_.connections_max;
    if (sessions_.size() >= settings_.connections_max + refusals_most) return;
    try {
      auto session = std::make_shared<Session>(
          std::move(socket), coordinator_, settings_,
          [this](awaitable<void> coroutine) { start(std::move(coroutine)); });
      sessions_.push_back(session);
      start(Session::run(session, full));
    } catch (const std::exception& error) {
      log::warn("workers' port: {}",
                error.what());  // the peer is gone before its address could be asked for
    }
  }

  boost::asio::any_io_executor executor_;
  Coordinator& coordinator_;
  SessionSettings settings_;
  tcp::acceptor acceptor_;
  boost::asio::steady_timer pause_;
  boost::asio::steady_timer all_ended_;
  std::vector<std::weak_ptr<Session>> sessions_;
  std::size_t running_ = 0;
  std::uint16_t port_ = 0;
  bool stopping_ = false;
};

}  // namespace

std::unique_ptr<WorkerListener> WorkerListener::open(boost::asio::any_io_executor executor,
                                                     Coordinator& coordinator,
                                                     SessionSettings settings) {
  return std::make_unique<Listener>(executor, coordinator, std::move(settings));
}

}  // namespace tessera::server
