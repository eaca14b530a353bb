#pragma once
#include <sys/mman.h>

#include <cstddef>
#include <memory>
#include <new>
#include <span>
#include <type_traits>
#include <vector>

namespace tessera::accel {

/// For arrays that are read at random places while rendering. What is large stands on huge pages
/// where the system has them: a face of a million is then one wait for memory, not that and a walk
/// through page tables.
template <class T>
class LargePages {
 public:
  using value_type = T;

  LargePages() = default;
  template <class U>
  explicit LargePages(const LargePages<U>& /*other*/) {}

  [[nodiscard]] T* allocate(std::size_t count) {
    const std::size_t bytes = count * sizeof(T);
    if (bytes < page) return std::allocator<T>().allocate(count);
    void* const memory = ::operator new (bytes, std::align_val_t{page});
    // Only whole huge pages; the end stays on small ones. A system without them says no.
    (void)madvise(memory, bytes / page * page, MADV_HUGEPAGE);
    return static_cast<T*>(memory);
  }
  void deallocate(T* items, std::size_t count) {
    if (count * sizeof(T) < page) return std::allocator<T>().deallocate(items, count);
    ::operator delete (items, std::align_val_t{page});
  }
  bool operator==(const LargePages&) const = default;

 private:
  static constexpr std::size_t page = std::size_t{1} << 21;
};

/// An array like any other, on such pages.
template <class T>
using LargeVector = std::vector<T, LargePages<T>>;

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
  LargeVector<T> items_;
  std::size_t count_ = 0;
};

}  // namespace tessera::accel
