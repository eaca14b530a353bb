#pragma once
#include <boost/asio/awaitable.hpp>
#include <boost/asio/thread_pool.hpp>
#include <cstdint>

#include "common/base/clock.hpp"
#include "server/http/access.hpp"
#include "server/http/message.hpp"

/// Answers requests. Knows no socket.
namespace tessera::assets {
class BlobStore;
}

namespace tessera::server {

class Coordinator;

struct ApiSettings {
  AccessSettings access;
  Duration keep_alive = std::chrono::seconds(10);  ///< between comments on a silent event stream
};

/// Counted by the listener, shown by /metrics.
struct HttpCounters {
  std::uint64_t requests = 0;
  std::uint64_t connections_accepted = 0;
  std::uint64_t connections_refused = 0;
  std::size_t connections_open = 0;
  std::uint64_t blob_bytes_received = 0;  ///< of uploads, as far as they came
};

/// Everything that handlers work with. On the I/O thread; `files` is where file work is done.
struct ApiContext {
  Coordinator& coordinator;
  assets::BlobStore& blobs;
  boost::asio::thread_pool& files;
  ApiSettings settings;
  HttpCounters counters;
};

class Api {
 public:
  /// All of these must outlive it.
  Api(Coordinator& coordinator, assets::BlobStore& blobs, boost::asio::thread_pool& files,
      ApiSettings settings);

  /// The answer to `request`: access is checked, the route found, its handler run, and an Error
  /// made a problem. `request` and its body must live until this resumes.
  boost::asio::awaitable<HttpResponse> handle(HttpRequest& request);

  [[nodiscard]] HttpCounters& counters() { return context_.counters; }
  /// The port is known once the listener stands: Host and Origin are checked against it.
  void set_port(std::uint16_t port) { context_.settings.access.port = port; }

 private:
  boost::asio::awaitable<HttpResponse> dispatch(HttpRequest& request);
  ApiContext context_;
};

}  // namespace tessera::server
