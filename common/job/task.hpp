#pragma once
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace tessera {

/// A job's number within its coordinator's data folder, from 1. People and HTTP write it as decimal
/// digits.
using JobId = std::uint64_t;

/// Which part of a job: tile and pass count from 0, frames are the job's own numbers.
struct TaskId {
  std::int32_t frame = 0;
  std::uint32_t tile = 0;
  std::uint32_t pass = 0;
  auto operator<=>(const TaskId&) const = default;
};

/// One attempt at a task by one worker. The epoch counts the coordinator's starts, so that numbers
/// never repeat.
struct LeaseId {
  std::uint64_t epoch = 0;
  std::uint64_t number = 0;
  auto operator<=>(const LeaseId&) const = default;
};

/// From decimal digits alone, at least 1.
std::optional<JobId> job_id_from(std::string_view text);
/// "frame 1 tile 17 pass 3": for logs and messages.
std::string text_of(const TaskId& task);

}  // namespace tessera

template <>
struct std::hash<tessera::TaskId> {
  std::size_t operator()(const tessera::TaskId& task) const noexcept {
    std::uint64_t value =
        (static_cast<std::uint64_t>(static_cast<std::uint32_t>(task.frame)) << 32) | task.tile;
    value = (value ^ (static_cast<std::uint64_t>(task.pass) << 20)) * 0x9e3779b97f4a7c15ULL;
    return static_cast<std::size_t>(value ^ (value >> 29));
  }
};
template <>
struct std::hash<tessera::LeaseId> {
  std::size_t operator()(const tessera::LeaseId& lease) const noexcept {
    return static_cast<std::size_t>((lease.number ^ (lease.epoch << 48)) * 0x9e3779b97f4a7c15ULL);
  }
};
