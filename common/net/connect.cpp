#include <fmt/format.h>

#include <boost/asio/connect.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <memory>
#include <string>
#include <utility>

#include "common/base/error.hpp"
#include "common/net/framed_stream.hpp"

namespace tessera::net {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

asio::awaitable<FramedStream> FramedStream::connect(asio::any_io_executor executor, Address address,
                                                    Duration wait, StreamSettings settings) {
  // One timer for both steps; the operations' ends wait for nothing but it.
  struct Dial {
    explicit Dial(const asio::any_io_executor& on) : resolver(on), socket(on), timer(on) {}
    tcp::resolver resolver;
    tcp::socket socket;
    asio::steady_timer timer;
    bool late = false;
  };
  const auto dial = std::make_shared<Dial>(executor);
  dial->timer.expires_after(wait);
  dial->timer.async_wait([dial](error_code error) {
    if (error) return;
    dial->late = true;
    dial->resolver.cancel();
    error_code ignored;
    dial->socket.close(ignored);
  });
  const auto fail = [&address, wait, dial](const error_code& error) {
    const std::string why =
        dial->late ? fmt::format("no answer within {} s", seconds(wait)) : error.message();
    throw Error(ErrorKind::unreachable, fmt::format("cannot reach {}: {}", address.text(), why));
  };
  error_code error;
  const std::string port = std::to_string(address.port);
  auto token = asio::redirect_error(asio::use_awaitable, error);
  const tcp::resolver::results_type found =
      co_await dial->resolver.async_resolve(address.host, port, token);
  if (!error && !dial->late) co_await asio::async_connect(dial->socket, found, token);
  dial->timer.cancel();
  if (error || dial->late) fail(error);
  co_return FramedStream(std::move(dial->socket), settings);
}

tcp::acceptor listen(const asio::any_io_executor& executor, const Address& address) {
  error_code error;
  tcp::resolver resolver(executor);
  const auto found =
      resolver.resolve(address.host, std::to_string(address.port), tcp::resolver::passive, error);
  tcp::acceptor acceptor(executor);
  if (!error) {
    const tcp::endpoint endpoint = found.begin()->endpoint();
    acceptor.open(endpoint.protocol(), error);
    if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
    if (!error) acceptor.bind(endpoint, error);
    if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
  }
  if (error)
    throw Error(ErrorKind::failed,
                fmt::format("cannot listen on {}: {}", address.text(), error.message()));
  return acceptor;
}

}  // namespace tessera::net
