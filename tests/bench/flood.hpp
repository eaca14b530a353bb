#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include "tests/farm/scripted_worker.hpp"

namespace tessera::farm_test {

/// Takes tasks and answers at once with tiles made beforehand, as a worker of boundless speed
/// would.
class Flood {
 public:
  /// `number` tells several apart.
  Flood(const std::string& address, int number);

  /// Until no task comes for 3 s, or the connection ends, or `stop`.
  void run();

  std::atomic<bool> stop = false;
  std::atomic<std::int64_t> delivered = 0, bytes = 0;  ///< results, and their EXRs

 private:
  std::vector<std::byte> tile_for(const AssignedTask& task);

  ScriptedWorker worker_;
  std::map<std::tuple<std::uint32_t, int, int>, image::TileImage> made_;
  std::vector<float> noise_ = std::vector<float>(std::size_t{1} << 20);
  std::size_t tiles_ = 0;
};

/// Several, each on a thread of its own.
class Floods {
 public:
  Floods(const std::string& address, int count);
  /// Ends them.
  ~Floods();
  Floods(const Floods&) = delete;
  Floods& operator=(const Floods&) = delete;

  [[nodiscard]] std::int64_t delivered() const;
  [[nodiscard]] std::int64_t bytes() const;

 private:
  std::vector<std::unique_ptr<Flood>> floods_;
  std::vector<std::thread> threads_;
};

}  // namespace tessera::farm_test
