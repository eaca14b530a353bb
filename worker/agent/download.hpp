#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "common/assets/blob_store.hpp"
#include "common/base/clock.hpp"
#include "common/net/http_clients.hpp"

namespace tessera::agent {

/// How often a blob is asked for.
struct Patience {
  int tries = 4;  ///< of each blob, that bring nothing of it, one after another
  Duration first_wait = std::chrono::milliseconds(250);  ///< between tries; doubled each time
};

/// A blob that is lacking.
struct Lacking {
  Digest digest;
  std::uint64_t most = 0;  ///< bytes that it may have
};

/// Blobs on their way from the server into the cache, several at once; one that breaks off goes on
/// where it broke off. Runs on the calling thread.
class Download {
 public:
  /// `on_bytes` is told how many have come, of all.
  Download(assets::BlobStore& cache, const Patience& patience, std::vector<Lacking> blobs,
           std::function<void(std::uint64_t)> on_bytes)
      : cache_(cache),
        patience_(patience),
        blobs_(std::move(blobs)),
        on_bytes_(std::move(on_bytes)) {}

  /// Until all are there, or `stop` was asked for. Throws Error that names the blob.
  void run(const std::string& url, const std::string& token, const std::stop_token& stop);

 private:
  using Writer = std::optional<assets::BlobStore::Writer>;  ///< holds what came of a blob

  boost::asio::awaitable<void> get_some(net::HttpClients& all, net::HttpClient& client);
  boost::asio::awaitable<void> get(net::HttpClients& all, net::HttpClient& client, Lacking blob);
  /// The blob, or what is lacking of it in `writer`. Gives what went wrong where another attempt
  /// may go better.
  boost::asio::awaitable<std::exception_ptr> get_once(net::HttpClient& client, const Lacking& blob,
                                                      Writer& writer);
  void finish(const Lacking& blob, Writer& writer);
  void restart(const Lacking& blob, Writer& writer);

  assets::BlobStore& cache_;
  Patience patience_;
  std::vector<Lacking> blobs_;
  std::function<void(std::uint64_t)> on_bytes_;
  std::size_t next_ = 0;
  std::uint64_t done_ = 0;  ///< bytes
};

}  // namespace tessera::agent
