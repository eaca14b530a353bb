#pragma once
#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <filesystem>
#include <memory>
#include <string>

#include "common/base/clock.hpp"
#include "common/net/address.hpp"
#include "worker/agent/agent_state.hpp"
#include "worker/agent/crew.hpp"
#include "worker/agent/fetch.hpp"
#include "worker/agent/renderer.hpp"

/// A worker's whole life: connect, lease, render, deliver, leave.
namespace tessera::agent {

struct AgentSettings {
  net::Address server;
  std::string token;
  std::string name;  ///< for people; a plain name
  std::filesystem::path cache;
  FetchSettings fetch;
  StateSettings state;
  Duration connect_wait = std::chrono::seconds(5);
  Duration drain_wait = std::chrono::seconds(20);  ///< what still renders then is given up
  Duration drain_alone_wait =
      std::chrono::seconds(2);  ///< for a coordinator that is away, to deliver what is left
};

/// Everything but rendering, encoding and preparing happens on the thread that runs `io`.
class Agent {
 public:
  /// Throws Error if the cache folder cannot be made.
  Agent(boost::asio::io_context& io, AgentSettings settings, TaskRenderer& renderer);
  /// Stops what renders, and waits for it.
  ~Agent();
  Agent(const Agent&) = delete;
  Agent& operator=(const Agent&) = delete;

  /// Lives until it is drained or refused for good. Gives the program's exit code.
  boost::asio::awaitable<int> run();
  /// Finishes what renders, delivers it, gives the rest back, and leaves: run() then gives 0. On
  /// the thread that runs `io`.
  void drain(const std::string& reason);
  [[nodiscard]] CrewStats stats() const;

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace tessera::agent
