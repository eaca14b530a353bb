#pragma once
#include <boost/asio/awaitable.hpp>
#include <boost/asio/steady_timer.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/net/framed_stream.hpp"
#include "server/coordinator/coordinator.hpp"
#include "server/session/listener.hpp"

/// One worker's connection, from its first byte to its last.
namespace tessera::server {

/// Lives in a shared_ptr: its coroutines keep it. The listener owns the coroutines: it starts run()
/// and closing() and counts both until they end.
class Session : public WorkerLink, public std::enable_shared_from_this<Session> {
 public:
  /// Starts a coroutine that the listener counts.
  using Spawn = std::function<void(boost::asio::awaitable<void>)>;

  Session(boost::asio::ip::tcp::socket socket, Coordinator& coordinator,
          const SessionSettings& settings, Spawn spawn);

  /// The whole life; ends when the connection has ended. Never throws. `full`: refuse it at once.
  static boost::asio::awaitable<void> run(std::shared_ptr<Session> self, bool full);
  /// The coordinator stops: Bye to the worker, then the end.
  void stop(const std::string& reason);

  // ---- WorkerLink ----
  void send(wire::Message message) override;
  void close(std::string reason) override;
  void hold(bool held) override;

 private:
  boost::asio::awaitable<bool> shake_hands();
  boost::asio::awaitable<void> listen_to_worker();
  boost::asio::awaitable<void> wait_while_held();
  void take(net::Incoming incoming);
  /// Says a last message and ends the connection once it is written, or after a second.
  void end_with(const wire::Message& last, const std::string& reason);
  static boost::asio::awaitable<void> closing(std::shared_ptr<Session> self, std::string reason);
  void leave();

  boost::asio::steady_timer held_timer_;
  net::FramedStream stream_;
  Coordinator& coordinator_;
  const SessionSettings& settings_;
  Spawn spawn_;
  std::string who_;  ///< the peer's address, with the worker's name once that is known
  std::optional<WorkerId> worker_;  ///< while the coordinator knows this connection
  std::optional<std::vector<wire::Message>>
      joining_;  ///< what is to follow the welcome, while that is made
  bool held_ = false;
  bool ending_ = false;  ///< the last message is queued
  bool clean_ = false;   ///< the worker said bye, or the coordinator stops
};

}  // namespace tessera::server
