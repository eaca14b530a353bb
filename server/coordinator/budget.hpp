#pragma once
#include <atomic>
#include <cstddef>
#include <memory>

/// Bytes of results that are on their way: from arrival until they are folded, or wait in the
/// journal alone.
namespace tessera::server {

/// Shares are taken on the I/O thread and end on any thread.
class Budget {
 public:
  /// The share counts until the last copy of it is gone. It may outlive the budget.
  [[nodiscard]] std::shared_ptr<void> take(std::size_t bytes) {
    used_->fetch_add(bytes, std::memory_order_relaxed);
    return {nullptr,
            [used = used_, bytes](void*) { used->fetch_sub(bytes, std::memory_order_relaxed); }};
  }
  [[nodiscard]] std::size_t used() const { return used_->load(std::memory_order_relaxed); }

 private:
  std::shared_ptr<std::atomic<std::size_t>> used_ = std::make_shared<std::atomic<std::size_t>>(0);
};

}  // namespace tessera::server
