#pragma once
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <stop_token>
#include <thread>

#include "common/base/clock.hpp"
#include "worker/agent/renderer.hpp"

namespace tessera::agent {

/// Says once a second that something gets on which cannot say itself how far it is: fractions that
/// grow, more slowly with time, and stay below `most`. After half an hour they grow no more: what
/// has not ended by then has stopped.
class Ticker {
 public:
  Ticker(const Fraction& progress, double most)
      : thread_([this, &progress, most](const std::stop_token& stop) {
          const auto began = std::chrono::steady_clock::now();
          std::unique_lock lock(mutex_);
          while (!wake_.wait_for(lock, stop, std::chrono::seconds(1), [] { return false; })) {
            if (stop.stop_requested()) return;
            const double passed = seconds(std::chrono::steady_clock::now() - began);
            if (passed > 1800) return;
            progress(most * passed / (passed + 60));
          }
        }) {}

 private:
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::jthread thread_;
};

}  // namespace tessera::agent
