#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <utility>

#include "common/base/clock.hpp"

namespace tessera::sim {

/// Draws that are the same with every standard library (SplitMix64).
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next();
  /// Uniform in [0, 1).
  double unit() { return static_cast<double>(next() >> 11) * 0x1p-53; }
  double between(double low, double high) { return low + (high - low) * unit(); }
  /// Whole, in [low, high].
  std::int64_t whole(std::int64_t low, std::int64_t high) {
    return low + static_cast<std::int64_t>(next() % static_cast<std::uint64_t>(high - low + 1));
  }
  bool chance(double probability) { return unit() < probability; }

 private:
  std::uint64_t state_;
};

Duration from_seconds(double seconds);

/// Virtual time: what is to happen, in order; at the same instant in the order in which it was
/// asked for.
class Events {
 public:
  [[nodiscard]] Instant now() const { return now_; }
  [[nodiscard]] double seconds_now() const { return seconds(now_ - start); }
  void at(Instant instant, std::function<void()> what);
  void after(double delay, std::function<void()> what) {
    at(now_ + from_seconds(delay), std::move(what));
  }
  /// The next event; false if there is none.
  bool step();
  [[nodiscard]] std::uint64_t count() const { return sequence_; }

 private:
  static constexpr Instant start{std::chrono::hours(1)};
  Instant now_ = start;
  std::uint64_t sequence_ = 0;
  std::map<std::pair<Instant, std::uint64_t>, std::function<void()>> queue_;
};

}  // namespace tessera::sim
