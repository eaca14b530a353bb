#pragma once
#include <condition_variable>
#include <memory>
#include <mutex>
#include <stop_token>
#include <thread>
#include <vector>

#include "worker/agent/renderer.hpp"

namespace tessera::agent {

/// Lets go of scenes on a thread of its own: if it is the last that has one, gigabytes are freed,
/// which takes seconds. Thread-safe.
class SceneBin {
 public:
  SceneBin();
  /// Waits until it is empty.
  ~SceneBin();
  SceneBin(const SceneBin&) = delete;
  SceneBin& operator=(const SceneBin&) = delete;

  void put(std::vector<std::shared_ptr<const PreparedScene>> scenes);
  /// Waits until all that was put into it is freed, or is somebody else's; or for the stop.
  void wait_until_empty(const std::stop_token& stop);

 private:
  void work();

  std::mutex mutex_;
  std::condition_variable wake_;
  std::condition_variable_any emptied_;
  bool ending_ = false;
  bool freeing_ = false;
  std::vector<std::shared_ptr<const PreparedScene>> scenes_;
  std::thread thread_;
};

}  // namespace tessera::agent
