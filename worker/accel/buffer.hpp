#pragma once
#include <cstddef>
#include <memory>
#include <span>
#include <type_traits>
#include <vector>

namespace tessera::accel {

/// A fixed array with 16 readable bytes behind its end, as Embree asks of buffers that it shares:
/// it loads whole registers.
template <class T>
class Buffer {
 public:
  static_assert(std::is_trivially_copyable_v<T>);
  Buffer() = default;
  explicit Buffer(std::size_t count) : items_(count + padding), count_(count) {}
  explicit Buffer(std::span<const T> from) : Buffer(from.size()) {
    for (std::size_t i = 0; i < count_; ++i) items_[i] = from[i];
  }

  [[nodiscard]] std::size_t size() const { return count_; }
  [[nodiscard]] bool empty() const { return count_ == 0; }
  [[nodiscard]] T* data() { return items_.data(); }
  [[nodiscard]] const T* data() const { return items_.data(); }
  T& operator[](std::size_t i) { return items_[i]; }
  const T& operator[](std::size_t i) const { return items_[i]; }
  [[nodiscard]] std::span<T> span() { return {items_.data(), count_}; }
  [[nodiscard]] std::span<const T> span() const { return {items_.data(), count_}; }
  [[nodiscard]] std::size_t bytes() const { return items_.size() * sizeof(T); }

 private:
  static constexpr std::size_t padding = (16 + sizeof(T) - 1) / sizeof(T);
  std::vector<T> items_;
  std::size_t count_ = 0;
};

}  // namespace tessera::accel
