#pragma once
#include <atomic>
#include <mutex>
#include <string>

#include "worker/accel/accel.hpp"
#include "worker/accel/embree.hpp"

namespace tessera::accel {

struct Device::State {
  RTCDevice handle = nullptr;
  std::string isa;
  std::atomic<std::int64_t> memory{0}, memory_peak{0};
  std::mutex mutex;
  std::string last_message;  ///< guarded by mutex

  State() = default;
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State();
  /// Throws Error{failed} if this thread's last call failed.
  void check(const char* what);
  /// Throws Error{failed} if this Embree takes no notice of masks.
  void require_masks() const;
};

}  // namespace tessera::accel
