#include "server/http/listener.hpp"

#include <fmt/format.h>

#include <boost/asio/bind_cancellation_slot.hpp>
#include <boost/asio/cancellation_signal.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <cassert>
#include <list>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "common/net/address.hpp"
#include "server/http/connection.hpp"
#include "server/http/response_writer.hpp"

namespace tessera::server {

namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

class OpenHttpListener : public HttpListener {
 public:
  OpenHttpListener(asio::any_io_executor executor, Api& api, asio::thread_pool& files,
                   HttpSettings settings)
      : executor_(executor),
        api_(api),
        files_(files),
        settings_(std::move(settings)),
        acceptor_(executor),
        ended_(executor) {
    listen();
    api_.set_port(port_);
    running_ = 1;
    asio::co_spawn(executor_, accept_loop(),
                   asio::bind_cancellation_slot(
                       accepting_.slot(), [this](const std::exception_ptr&) { one_ended(); }));
  }
  ~OpenHttpListener() override { assert(running_ == 0 && "stop() was not awaited"); }

  [[nodiscard]] std::uint16_t port() const override { return port_; }

  asio::awaitable<void> stop() override {
    stopping_ = true;
    boost::system::error_code error;
    acceptor_.close(error);
    accepting_.emit(asio::cancellation_type::terminal);
    for (asio::cancellation_signal& connection : connections_)
      connection.emit(asio::cancellation_type::terminal);
    while (running_ > 0) {
      ended_.expires_at(asio::steady_timer::time_point::max());
      co_await ended_.async_wait(asio::redirect_error(asio::use_awaitable, error));
    }
  }

 private:
  void listen() {
    try {
      const tcp::endpoint endpoint(asio::ip::make_address(settings_.address), settings_.port);
      acceptor_.open(endpoint.protocol());
      acceptor_.set_option(tcp::acceptor::reuse_address(true));
      acceptor_.bind(endpoint);
      acceptor_.listen();
      port_ = acceptor_.local_endpoint().port();
    } catch (const boost::system::system_error& error) {
      const net::Address address{settings_.address, settings_.port};
      throw Error(ErrorKind::failed, fmt::format("cannot listen for HTTP on {}: {}", address.text(),
                                                 error.code().message()));
    }
  }

  asio::awaitable<void> accept_loop() {
    while (!stopping_) {
      boost::system::error_code error;
      tcp::socket socket =
          co_await acceptor_.async_accept(asio::redirect_error(asio::use_awaitable, error));
      if (stopping_) co_return;
      if (error) {  // no descriptors, or the peer is gone again: neither may end the listener
        asio::steady_timer pause(executor_, std::chrono::milliseconds(100));
        co_await pause.async_wait(asio::redirect_error(asio::use_awaitable, error));
        continue;
      }
      if (connections_.size() >= settings_.connections_max)
        refuse(std::move(socket));
      else
        start(std::move(socket));
    }
  }

  /// Says 503 if the socket takes it at once, and waits for nothing.
  void refuse(tcp::socket socket) {
    ++api_.counters().connections_refused;
    const HttpResponse full = problem(503, "this server has as many connections as it takes");
    const std::string text = response_head(full, false) + std::get<std::string>(full.body);
    boost::system::error_code error;
    socket.non_blocking(true, error);
    socket.write_some(asio::buffer(text), error);
    socket.shutdown(tcp::socket::shutdown_send, error);
  }

  void start(tcp::socket socket) {
    ++api_.counters().connections_accepted;
    ++running_;
    const auto place = connections_.emplace(connections_.end());
    api_.counters().connections_open = connections_.size();
    asio::co_spawn(
        executor_, serve_connection(std::move(socket), api_, files_, settings_),
        asio::bind_cancellation_slot(place->slot(), [this, place](const std::exception_ptr& error) {
          note(error);
          connections_.erase(place);
          api_.counters().connections_open = connections_.size();
          one_ended();
        }));
  }

  void note(const std::exception_ptr& error) const {
    if (!error || stopping_) return;
    try {
      std::rethrow_exception(error);
    } catch (const std::exception& problem) {
      log::warn("an HTTP connection ended by an error: {}", problem.what());
    }
  }

  void one_ended() {
    --running_;
    ended_.cancel();
  }

  asio::any_io_executor executor_;
  Api& api_;
  asio::thread_pool& files_;
  HttpSettings settings_;
  tcp::acceptor acceptor_;
  asio::steady_timer ended_;  ///< cancelled when a coroutine has ended
  asio::cancellation_signal accepting_;
  std::list<asio::cancellation_signal> connections_;
  std::size_t running_ = 0;  ///< coroutines
  std::uint16_t port_ = 0;
  bool stopping_ = false;
};

}  // namespace

std::unique_ptr<HttpListener> HttpListener::open(asio::any_io_executor executor, Api& api,
                                                 asio::thread_pool& files, HttpSettings settings) {
  return std::make_unique<OpenHttpListener>(std::move(executor), api, files, std::move(settings));
}

}  // namespace tessera::server
