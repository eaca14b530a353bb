#pragma once
#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstddef>
#include <memory>
#include <vector>

#include "common/base/clock.hpp"

/// Waiting and owning for what runs on the I/O thread.
namespace tessera::server {

/// Coroutines wait until something has changed, and then look again.
class Signal {
 public:
  explicit Signal(const boost::asio::any_io_executor& executor);
  /// Wakes all who wait now.
  void notify();
  /// Until the next notify(); spurious wake-ups happen. The signal may die meanwhile, which wakes
  /// too.
  boost::asio::awaitable<void> wait();

 private:
  std::shared_ptr<boost::asio::steady_timer> timer_;
};

/// Owns coroutines, and counts work that is under way on other threads: ended() resumes when all of
/// it has ended.
class Crew {
 public:
  explicit Crew(const boost::asio::any_io_executor& executor);
  /// What a coroutine throws is logged with `name`.
  void start(const char* name, boost::asio::awaitable<void> coroutine);
  /// Work that is counted by hand: each begun() has its finished().
  void begun() { ++running_; }
  void finished();
  /// Makes every pause() end at once, now and from now on.
  void stop();
  [[nodiscard]] bool stopping() const { return stopping_; }
  /// Waits so long, or until stop().
  boost::asio::awaitable<void> pause(Duration time);
  boost::asio::awaitable<void> ended();

 private:
  boost::asio::any_io_executor executor_;
  Signal all_ended_;
  std::vector<boost::asio::steady_timer*> pauses_;  ///< of the coroutines in pause()
  std::size_t running_ = 0;
  bool stopping_ = false;
};

}  // namespace tessera::server
