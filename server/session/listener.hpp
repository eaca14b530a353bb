#pragma once
#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <cstdint>
#include <memory>
#include <string>

#include "common/base/clock.hpp"
#include "common/base/limits.hpp"

/// The workers' port: accepts connections and keeps one coroutine for each of them.
namespace tessera::server {

class Coordinator;

struct SessionSettings {
  std::string address = "127.0.0.1";  ///< to listen on: an IP address
  std::uint16_t port = 8421;          ///< 0 picks one; WorkerListener::port() says which
  std::string token;                  ///< every worker must show it; empty: none is needed
  std::string blob_url;  ///< given to workers; empty: "http://" + the address dialled + http_port
  std::uint16_t http_port = 8420;  ///< where blobs are served, for a blob_url that is made
  std::string blob_token;          ///< given to workers, to be shown when they fetch blobs
  Duration heartbeat = std::chrono::seconds(1);  ///< asked of workers: SchedulerSettings::heartbeat
  std::size_t connections_max = limits::workers_max;
  Duration handshake_time = limits::handshake_time;
};

/// Listens from the moment that it exists. Everything runs on the coordinator's executor, the I/O
/// thread.
class WorkerListener {
 public:
  /// Throws Error{failed} with address and port if they cannot be listened on. `coordinator` must
  /// outlive the listener.
  static std::unique_ptr<WorkerListener> open(boost::asio::any_io_executor executor,
                                              Coordinator& coordinator, SessionSettings settings);
  virtual ~WorkerListener() = default;

  [[nodiscard]] virtual std::uint16_t port() const = 0;
  /// Connections open at present, those in their handshake among them.
  [[nodiscard]] virtual std::size_t connections() const = 0;
  /// Accepts no more, says Bye to every worker, and resumes when the last session has ended. Call
  /// it before Coordinator::stop and before the executor stops; the destructor expects it.
  virtual boost::asio::awaitable<void> stop() = 0;
};

}  // namespace tessera::server
