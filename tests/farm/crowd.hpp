#pragma once
#include <cstddef>
#include <memory>
#include <string>

#include "tests/farm/process.hpp"

/// More workers than one would start processes for.
namespace tessera::farm_test {

/// Workers without renderers, a connection each, all on one thread of this process. They take
/// leases and answer with ScriptedWorker::good_tile(): values that depend on task and pixel alone.
class Crowd {
 public:
  /// Begins to connect to the workers' port "127.0.0.1:PORT".
  Crowd(const std::string& address, std::size_t count);
  /// Each says bye.
  ~Crowd();
  Crowd(const Crowd&) = delete;
  Crowd& operator=(const Crowd&) = delete;

  /// Until so many have been welcomed; false after `most`.
  [[nodiscard]] bool wait_for_welcomes(std::size_t count, Seconds most) const;
  /// Until so many have been given a task each, whoever's result of it came first; false after
  /// `most`.
  [[nodiscard]] bool wait_for_work(std::size_t count, Seconds most) const;
  /// Why connections ended that should not have.
  [[nodiscard]] std::string troubles() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera::farm_test
