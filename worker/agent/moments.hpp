#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>

namespace tessera::agent {

/// A scene at the moments of time that are asked for, each built once, however many ask for it at
/// the same time; the `kept` moments asked for last stay. Thread-safe.
template <class Built>
class Moments {
 public:
  /// Empty where it was given up.
  using Build = std::function<std::shared_ptr<const Built>()>;

  explicit Moments(std::size_t kept) : kept_(kept) {}

  /// Builds it, or waits while another thread does. Throws what `build` throws: the next to ask
  /// tries again.
  std::shared_ptr<const Built> at(double time, const Build& build) {
    const std::shared_ptr<Moment> moment = [&] {
      const std::lock_guard lock(mutex_);
      return entry(time);
    }();
    const std::lock_guard building(moment->building);
    if (!moment->built) moment->built = build();
    return moment->built;
  }

 private:
  struct Moment {
    std::mutex building;
    std::shared_ptr<const Built> built;
    std::uint64_t used = 0;
  };

  /// The moment, marked as used; the one that was used longest ago makes room for it.
  std::shared_ptr<Moment> entry(double time) {
    std::shared_ptr<Moment>& found = moments_[time];
    if (!found) found = std::make_shared<Moment>();
    found->used = ++uses_;
    const std::shared_ptr<Moment> out = found;
    while (moments_.size() > kept_) {
      auto oldest = moments_.begin();
      for (auto one = moments_.begin(); one != moments_.end(); ++one)
        if (one->second->used < oldest->second->used) oldest = one;
      moments_.erase(oldest);
    }
    return out;
  }

  std::size_t kept_;
  std::mutex mutex_;
  std::uint64_t uses_ = 0;
  std::map<double, std::shared_ptr<Moment>> moments_;
};

}  // namespace tessera::agent
