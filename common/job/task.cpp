#include "common/job/task.hpp"

#include <fmt/format.h>

#include <charconv>

namespace tessera {

std::optional<JobId> job_id_from(std::string_view text) {
  JobId id = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), id);
  if (problem != std::errc{} || end != text.data() + text.size() || id == 0) return std::nullopt;
  return id;
}

std::string text_of(const TaskId& task) {
  return fmt::format("frame {} tile {} pass {}", task.frame, task.tile, task.pass);
}

}  // namespace tessera
