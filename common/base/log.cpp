#include "common/base/log.hpp"

#include <spdlog/sinks/ringbuffer_sink.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "common/base/error.hpp"
#include "common/base/names.hpp"

namespace tessera::log {

namespace {
spdlog::logger& logger() {
  static const std::shared_ptr<spdlog::logger> made = [] {
    auto it = std::make_shared<spdlog::logger>(
        "tessera", std::make_shared<spdlog::sinks::stderr_color_sink_mt>());
    it->set_pattern("%Y-%m-%d %H:%M:%S.%e %^%l%$ %v");
    it->flush_on(spdlog::level::warn);
    return it;
  }();
  return *made;
}

spdlog::level::level_enum level_of(Level level) {
  switch (level) {
    case Level::debug:
      return spdlog::level::debug;
    case Level::info:
      return spdlog::level::info;
    case Level::warn:
      return spdlog::level::warn;
    case Level::error:
      break;
  }
  return spdlog::level::err;
}
}  // namespace

namespace {
std::shared_ptr<spdlog::sinks::ringbuffer_sink_mt>& kept() {
  static std::shared_ptr<spdlog::sinks::ringbuffer_sink_mt> sink;
  return sink;
}
}  // namespace

void keep_recent(std::size_t lines) {
  if (kept()) std::erase(logger().sinks(), kept());
  kept() = std::make_shared<spdlog::sinks::ringbuffer_sink_mt>(lines);
  kept()->set_pattern("%Y-%m-%d %H:%M:%S.%e %l %v");
  logger().sinks().push_back(kept());
}

std::string recent() {
  if (!kept()) return {};
  std::string text;
  for (const std::string& line : kept()->last_formatted()) text += line;
  return text;
}

void set_level(Level level) { logger().set_level(level_of(level)); }

Level level_from(std::string_view name) {
  if (name == "debug") return Level::debug;
  if (name == "info") return Level::info;
  if (name == "warn") return Level::warn;
  if (name == "error") return Level::error;
  throw Error(ErrorKind::bad_input,
              unknown_name("log level", name, {"debug", "info", "warn", "error"}));
}

void write(Level level, std::string_view line) {
  logger().log(level_of(level), spdlog::string_view_t(line.data(), line.size()));
}

}  // namespace tessera::log
