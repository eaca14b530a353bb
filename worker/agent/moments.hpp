#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>

namespace tessera::agent {

/// A scene at the moments of time that are asked for, each built once, however many ask for it at
/// the same time. The `kept` moments asked for last stay, and those that are being built.
/// Thread-safe.
template <class Built>
class Moments {
 public:
  /// Empty where it was given up.
  using Build = std::function<std::shared_ptr<const Built>()>;

  explicit Moments(std::size_t kept) : kept_(kept) {}

  /// Builds it, or waits while another thread does. Throws what `build` throws: the next to ask
  /// tries again.
  std::shared_ptr<const Built> at(double time, const Build& build) {
    const std::shared_ptr<Moment> moment = entry(time);
    const std::lock_guard building(moment->building);
    if (!moment->built) moment->built = build();
    moment->is_built = moment->built != nullptr;
    return moment->built;
  }
  /// True if at() would neither build nor wait for long.
  [[nodiscard]] bool has(double time) {
    const std::lock_guard lock(mutex_);
    const auto found = moments_.find(time);
    return found != moments_.end() && found->second->is_built;
  }

 private:
  struct Moment {
    std::mutex building;
    std::shared_ptr<const Built> built;
    std::atomic<bool> is_built = false;
    std::uint64_t used = 0;
  };

  /// The moment, marked as used; the one that was used longest ago makes room for it.
  std::shared_ptr<Moment> entry(double time) {
    const std::lock_guard lock(mutex_);
    std::shared_ptr<Moment>& found = moments_[time];
    if (!found) found = std::make_shared<Moment>();
    found->used = ++uses_;
    std::shared_ptr<Moment> out = found;
    while (moments_.size() > kept_) {
      auto oldest = moments_.end();
      for (auto one = moments_.begin(); one != moments_.end(); ++one) {
        // One whose build failed, and that nobody tries again, is as good as built.
        const bool under_way = !one->second->is_built && one->second.use_count() > 1;
        if (one->second == out || under_way) continue;
        if (oldest == moments_.end() || one->second->used < oldest->second->used) oldest = one;
      }
      if (oldest == moments_.end()) break;
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
