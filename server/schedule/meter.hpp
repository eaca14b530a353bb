#pragma once
#include <cassert>

namespace tessera::server {

/// A rate over the last few seconds: amounts and the time they took, older ones counting ever less.
/// Known once they took long enough to be measured: a result that comes with its worker's `ready`
/// says nothing of its speed.
class Meter {
 public:
  /// What is so many seconds old counts half as much as what is new, or less.
  explicit Meter(double memory = 5) : memory_(memory) {}
  /// `amount` took `seconds` ≥ 0.
  void add(double amount, double seconds) {
    assert(seconds >= 0);
    const double keep = memory_ / (memory_ + seconds);
    amount_ = amount_ * keep + amount;
    seconds_ = seconds_ * keep + seconds;
  }
  [[nodiscard]] bool known() const { return amount_ > 0 && seconds_ >= least_time; }
  /// Amount a second, if nothing more has come for `idle` seconds since the last.
  [[nodiscard]] double rate(double idle = 0) const {
    const double keep = memory_ / (memory_ + idle);
    return known() ? amount_ * keep / (seconds_ * keep + idle) : 0;
  }

 private:
  static constexpr double least_time = 0.01;
  double memory_;  // seconds
  double amount_ = 0, seconds_ = 0;
};

}  // namespace tessera::server
