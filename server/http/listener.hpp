#pragma once
#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <cstdint>
#include <memory>
#include <string>

#include "common/base/clock.hpp"
#include "common/base/limits.hpp"
#include "server/http/api.hpp"

/// The people's port: HTTP/1.1, one coroutine for each connection.
namespace tessera::server {

struct HttpSettings {
  std::string address = "127.0.0.1";  ///< to listen on: an IP address
  std::uint16_t port = 8420;          ///< 0 picks one; HttpListener::port() says which
  std::size_t connections_max = limits::http_connections_max;
  Duration idle_time =
      limits::http_idle_time;  ///< for a whole header, or the next 64 KiB of a body
  Duration write_time = limits::http_write_time;  ///< for the next 64 KiB of an answer
};

/// Listens from the moment that it exists.
class HttpListener {
 public:
  /// Throws Error{failed} with address and port if they cannot be listened on. `api` and `files`
  /// must outlive the server.
  static std::unique_ptr<HttpListener> open(boost::asio::any_io_executor executor, Api& api,
                                            boost::asio::thread_pool& files, HttpSettings settings);
  virtual ~HttpListener() = default;

  [[nodiscard]] virtual std::uint16_t port() const = 0;
  /// Accepts no more, cancels what is under way, and resumes when the last connection has ended.
  /// Call it before the executor stops; the destructor expects it.
  virtual boost::asio::awaitable<void> stop() = 0;
};

}  // namespace tessera::server
