#pragma once
#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "common/base/clock.hpp"
#include "common/base/limits.hpp"
#include "common/net/address.hpp"

/// The whole coordinator, put together: data folder, workers' port and people's port.
namespace tessera::server {

struct ServerSettings {
  std::filesystem::path data;
  net::Address http{"127.0.0.1", net::default_http_port};      ///< port 0 picks one
  net::Address listen{"127.0.0.1", net::default_worker_port};  ///< for workers; port 0 picks one
  std::string token;       ///< every request and worker must show it; empty: none is needed
  bool insecure = false;   ///< listen off loopback although nothing is encrypted
  std::string public_url;  ///< how workers and browsers reach the HTTP port, where that is not its
                           ///< own address; may be empty
  int pool_threads = 2;    ///< decode, encode, hash and sync
  /// A preparation that has not got on for so many seconds is given up.
  int preparation_timeout = 1800;
  bool durable = true;  ///< false: no fsync, for the benchmark that shows its cost
  /// Bytes of films of unfinished frames in memory; 0: half of the machine's memory. The other half
  /// is for what is on its way to the disk, for pictures being encoded, and for the system.
  std::uint64_t film_memory = 0;
  std::optional<Duration> keep_jobs;            ///< jobs that have ended; nullopt: for good
  std::uint64_t disk_limit = 0;                 ///< bytes of the data folder; 0: no limit
  std::uint64_t blob_cache = 10 * limits::GiB;  ///< bytes that no job needs
};

/// Throws Error{bad_input} with a sentence for people: an address that is no IP address; one off
/// loopback without a token, or without leave to speak unencrypted; a token or an URL that cannot
/// be one.
void check(const ServerSettings& settings);

/// Opens everything when it is made; works while `context` runs, on one thread.
class Server {
 public:
  /// Throws Error: what check() refuses; Error{failed} for a port in use, a folder that is locked
  /// or damaged.
  Server(boost::asio::io_context& context, ServerSettings settings);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// Where it listens, with the ports that were picked.
  [[nodiscard]] const net::Address& http() const;
  [[nodiscard]] const net::Address& listen() const;
  /// {"http":"127.0.0.1:8420","listen":"127.0.0.1:8421"}: what the program prints when it is ready.
  [[nodiscard]] std::string ready_line() const;

  /// Ends people's connections, then workers', then the coordinator. Must be awaited before the
  /// destructor.
  boost::asio::awaitable<void> stop();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tessera::server
