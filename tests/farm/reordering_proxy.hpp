#pragma once
#include <atomic>
#include <chrono>
#include <cstddef>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

/// Stands between one worker and the coordinator and holds results back, to let the last go first.
namespace tessera::farm_test {

/// Listens on a loopback port that the system picks. What the coordinator says passes as it is; of
/// what the worker says, results are held until several are there or nothing more comes, and go on
/// with the highest pass first.
class ReorderingProxy {
 public:
  /// Holds up to `held_most` results; 1 lets each pass as it comes.
  explicit ReorderingProxy(const std::string& coordinator, std::size_t held_most = 30);
  ~ReorderingProxy();
  ReorderingProxy(const ReorderingProxy&) = delete;
  ReorderingProxy& operator=(const ReorderingProxy&) = delete;

  /// "127.0.0.1:PORT": where the worker connects to.
  [[nodiscard]] const std::string& address() const { return address_; }
  /// How many results have gone on ahead of one that came before them.
  [[nodiscard]] int swapped() const { return swapped_; }

  /// When a result was whole here, and how long its worker says it rendered.
  struct Seen {
    std::chrono::steady_clock::time_point when;
    double seconds = 0;
  };
  [[nodiscard]] std::vector<Seen> seen() const;

 private:
  void serve();
  void relay(int worker, int coordinator);

  std::string coordinator_, address_;
  std::size_t held_most_;
  mutable std::mutex mutex_;
  std::vector<Seen> seen_;  ///< under mutex_
  int listener_ = -1;
  std::atomic<bool> stop_ = false;
  std::atomic<int> swapped_ = 0;
  std::thread thread_;
};

}  // namespace tessera::farm_test
