#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>

#include "common/base/error.hpp"
#include "common/base/json.hpp"
#include "common/wire/codec.hpp"
#include "common/wire/codec_limits.hpp"

/// Values to JSON.
namespace tessera::wire {

namespace {
constexpr std::array<std::string_view, std::variant_size_v<Message>> names = {
    "hello",  "welcome",  "refused", "assign",   "preparing", "ready", "progress", "revoke",
    "result", "accepted", "stale",   "rejected", "failed",    "drain", "bye"};

/// At most `most` bytes, cut between characters.
std::string clipped(const std::string& text, std::size_t most = reason_most) {
  if (text.size() <= most) return text;
  std::size_t end = most;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
  return text.substr(0, end);
}

Json json_of(const LeaseId& lease) { return Json::array({lease.epoch, lease.number}); }
Json json_of(const TaskId& task) { return Json::array({task.frame, task.tile, task.pass}); }

Json header_of(const Hello& m) {
  return {{"token", m.token},
          {"name", m.name},
          {"identity", m.identity},
          {"threads", m.threads},
          {"build_id", m.build_id.hex()},
          {"version", m.version}};
}
Json header_of(const Welcome& m) {
  return {{"worker", m.worker},
          {"epoch", m.epoch},
          {"heartbeat_ms", m.heartbeat_ms},
          {"blob_url", m.blob_url},
          {"blob_token", m.blob_token}};
}
Json header_of(const Refused& m) {
  return {{"code", m.code}, {"reason", clipped(m.reason, short_most)}};
}
Json header_of(const Assign& m) {
  Json json = {{"lease", json_of(m.lease)},
               {"job", m.job},
               {"plan", m.plan.hex()},
               {"task", json_of(m.task)}};
  if (m.spec) json["spec"] = to_json(*m.spec);
  return json;
}
Json header_of(const Preparing& m) { return {{"job", m.job}, {"fraction", m.fraction}}; }
Json header_of(const Ready& m) { return {{"job", m.job}}; }
Json header_of(const Progress& m) {
  Json running = Json::array();
  for (const Progress::Running& one : m.running)
    running.push_back(Json::array({one.lease.epoch, one.lease.number, one.fraction}));
  Json json = {{"running", std::move(running)}};
  if (m.cache) json["cache"] = Json::array({m.cache->bytes, m.cache->most, m.cache->evictions});
  return json;
}
Json header_of(const Revoke& m) {
  Json leases = Json::array();
  for (const LeaseId& lease : m.leases) leases.push_back(json_of(lease));
  return {{"leases", std::move(leases)}, {"reason", clipped(m.reason)}};
}
Json header_of(const Result& m) {
  return {{"lease", json_of(m.lease)}, {"job", m.job},         {"plan", m.plan.hex()},
          {"task", json_of(m.task)},   {"samples", m.samples}, {"rays", m.rays},
          {"rejected", m.rejected},    {"seconds", m.seconds}, {"cpu_seconds", m.cpu_seconds}};
}
Json header_of(const Accepted& m) { return {{"lease", json_of(m.lease)}}; }
Json header_of(const Stale& m) { return {{"lease", json_of(m.lease)}}; }
Json header_of(const Rejected& m) {
  return {{"lease", json_of(m.lease)}, {"reason", clipped(m.reason)}};
}
Json header_of(const Failed& m) {
  Json json = {{"job", m.job}, {"code", m.code}, {"reason", clipped(m.reason)}};
  if (m.lease) json["lease"] = json_of(*m.lease);
  if (!m.log.empty()) json["log"] = clipped(m.log, log_most);
  return json;
}
Json header_of(const Drain& m) { return {{"reason", clipped(m.reason)}}; }
Json header_of(const Bye& m) { return {{"reason", clipped(m.reason)}}; }
}  // namespace

std::uint16_t type_of(const Message& message) {
  return static_cast<std::uint16_t>(message.index() + 1);
}

std::uint16_t message_types() { return static_cast<std::uint16_t>(names.size()); }

std::string_view name_of(std::uint16_t type) {
  return type >= 1 && type <= names.size() ? names[type - 1U] : std::string_view{};
}

bool has_body(std::uint16_t type) { return name_of(type) == "result"; }

EncodedMessage encode(const Message& message) {
  const auto check_count = [](std::size_t count) {
    if (count > leases_per_message)
      throw Error(
          ErrorKind::too_large,
          fmt::format("{} leases in one message; at most {} go in one", count, leases_per_message));
  };
  if (const auto* revoke = std::get_if<Revoke>(&message)) check_count(revoke->leases.size());
  if (const auto* progress = std::get_if<Progress>(&message)) check_count(progress->running.size());
  const Json header = std::visit([](const auto& m) { return header_of(m); }, message);
  return {.type = type_of(message),
          .header = header.dump(-1, ' ', false, Json::error_handler_t::replace)};
}

}  // namespace tessera::wire
