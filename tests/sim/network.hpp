#pragma once
#include <cstdint>
#include <memory>

#include "common/base/clock.hpp"
#include "server/schedule/actions.hpp"

namespace tessera::sim {

class Worker;

/// Until when nothing of a machine's passes the network, each way. What is under way waits.
struct Partition {
  Instant to_server{}, to_worker{};
};

/// One TCP connection: each direction keeps its order, each message takes a while, and what is on
/// its way when it is cut is lost.
struct Connection {
  Worker* worker = nullptr;
  bool open = true;  // bytes pass
  Instant cut_at{};
  Instant to_server_at{}, to_worker_at{};
  const Partition* partition = nullptr;  // the worker's

  // The coordinator's side, from hello on.
  server::WorkerId known_as = 0;
  std::uint64_t life = 0;  // of the coordinator that took the hello
  bool left = false;       // worker_left was said
};
using Link = std::shared_ptr<Connection>;

/// A result as it travels.
struct SentResult {
  LeaseId lease;
  JobId job = 0;
  TaskId task;
  Digest plan;           // as it was when the lease was granted
  bool corrupt = false;  // not a valid tile
};

/// A lease as it travels.
struct Assigned {
  server::GrantLease grant;
  Digest plan;
};

}  // namespace tessera::sim
