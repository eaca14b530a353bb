#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "common/job/task.hpp"

namespace tessera::server {

/// SipHash-2-4 (Aumasson and Bernstein, 2012) of `bytes`: a keyed hash that cannot be guessed
/// without the key.
std::uint64_t siphash(const std::array<std::uint8_t, 16>& key, std::span<const std::uint8_t> bytes);

/// Makes lease numbers that prove their own grant: a count in the upper 40 bits, so that numbers
/// never repeat within an epoch and sort by age, and in the lower 24 a keyed hash over epoch,
/// count, job, task and the worker's identity. Whether a lease was granted is then a question to
/// the number, not to a record of all grants ever made.
class LeaseNumbers {
 public:
  LeaseNumbers(std::uint64_t epoch, const std::array<std::uint8_t, 16>& key);

  LeaseId next(std::string_view identity, JobId job, const TaskId& task);
  /// True if this lease, of this epoch or an earlier one, was granted for this task to this
  /// identity.
  [[nodiscard]] bool granted(const LeaseId& lease, std::string_view identity, JobId job,
                             const TaskId& task) const;

 private:
  [[nodiscard]] std::uint64_t seal(std::uint64_t epoch, std::uint64_t count,
                                   std::string_view identity, JobId job, const TaskId& task) const;
  std::uint64_t epoch_;
  std::uint64_t count_ = 0;
  std::array<std::uint8_t, 16> key_;
};

}  // namespace tessera::server
