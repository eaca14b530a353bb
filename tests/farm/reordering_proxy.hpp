#pragma once
#include <atomic>
#include <string>
#include <thread>

/// Stands between one worker and the coordinator and holds results back, to let the last go first.
namespace tessera::farm_test {

/// Listens on a loopback port that the system picks. What the coordinator says passes as it is; of
/// what the worker says, results are held until several are there or nothing more comes, and go on
/// with the highest pass first.
class ReorderingProxy {
 public:
  explicit ReorderingProxy(const std::string& coordinator);
  ~ReorderingProxy();
  ReorderingProxy(const ReorderingProxy&) = delete;
  ReorderingProxy& operator=(const ReorderingProxy&) = delete;

  /// "127.0.0.1:PORT": where the worker connects to.
  [[nodiscard]] const std::string& address() const { return address_; }
  /// How many results have gone on ahead of one that came before them.
  [[nodiscard]] int swapped() const { return swapped_; }

 private:
  void serve();
  void relay(int worker, int coordinator);

  std::string coordinator_, address_;
  int listener_ = -1;
  std::atomic<bool> stop_ = false;
  std::atomic<int> swapped_ = 0;
  std::thread thread_;
};

}  // namespace tessera::farm_test
