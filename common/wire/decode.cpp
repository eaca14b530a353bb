#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "common/base/error.hpp"
#include "common/base/json.hpp"
#include "common/base/limits.hpp"
#include "common/base/names.hpp"
#include "common/wire/codec.hpp"
#include "common/wire/codec_limits.hpp"

/// JSON to values.
namespace tessera::wire {

namespace {
constexpr double seconds_most = 1e9;

std::uint64_t unsigned_in(const Json& value, std::uint64_t low, const ObjectReader& in,
                          std::string_view key) {
  const auto expected = [&] {
    return fmt::format("expected a whole number from {} to 2⁶⁴ − 1", low);
  };
  if (!value.is_number_unsigned())
    in.fail(key, fmt::format("{}, found {}", expected(), value.dump().substr(0, 40)));
  const auto number = value.get<std::uint64_t>();
  if (number < low) in.fail(key, fmt::format("{}, found {}", expected(), number));
  return number;
}
std::uint64_t unsigned_from(ObjectReader& in, std::string_view key, std::uint64_t low = 0) {
  return unsigned_in(in.required(key), low, in, key);
}

std::string text_from(ObjectReader& in, std::string_view key, std::size_t most) {
  std::string text = in.text(key);
  if (text.size() > most)
    in.fail(key, fmt::format("expected at most {} bytes, found {}", most, text.size()));
  return text;
}
std::string reason_from(ObjectReader& in) { return text_from(in, "reason", reason_most); }

double fraction_in(const Json& value, const ObjectReader& in, std::string_view key) {
  const double number = value.is_number() ? value.get<double>() : std::nan("");
  if (!(number >= 0 && number <= 1))
    in.fail(key,
            fmt::format("expected a number from 0 to 1, found {}", value.dump().substr(0, 40)));
  return number;
}

void expect_array(const Json& value, std::size_t size, const char* what, const ObjectReader& in,
                  std::string_view key) {
  if (!value.is_array() || value.size() != size)
    in.fail(key, fmt::format("expected {}, found {}", what, value.dump().substr(0, 40)));
}

LeaseId lease_in(const Json& value, const ObjectReader& in, std::string_view key) {
  expect_array(value, 2, "a lease as [epoch, number]", in, key);
  return {.epoch = unsigned_in(value[0], 0, in, key), .number = unsigned_in(value[1], 0, in, key)};
}
LeaseId lease_from(ObjectReader& in) { return lease_in(in.required("lease"), in, "lease"); }

TaskId task_from(ObjectReader& in) {
  const Json& value = in.required("task");
  expect_array(value, 3, "a task as [frame, tile, pass]", in, "task");
  const auto whole = [&](std::size_t at, std::int64_t low, std::int64_t high) {
    const Json& one = value[at];
    const bool fits = one.is_number_integer() &&
                      !(one.is_number_unsigned() && one.get<std::uint64_t>() > UINT32_MAX) &&
                      one.get<std::int64_t>() >= low && one.get<std::int64_t>() <= high;
    if (!fits)
      in.fail("task", fmt::format("expected a whole number from {} to {}, found {}", low, high,
                                  one.dump().substr(0, 40)));
    return one.get<std::int64_t>();
  };
  return {.frame = static_cast<std::int32_t>(whole(0, INT32_MIN, INT32_MAX)),
          .tile = static_cast<std::uint32_t>(whole(1, 0, UINT32_MAX)),
          .pass = static_cast<std::uint32_t>(whole(2, 0, UINT32_MAX))};
}

Digest digest_from(ObjectReader& in, std::string_view key) {
  const auto digest = Digest::from_hex(in.text(key));
  if (!digest) in.fail(key, "expected a SHA-256 as 64 hexadecimal digits");
  return *digest;
}

const Json& list_from(ObjectReader& in, std::string_view key) {
  const Json& list = in.required(key);
  if (!list.is_array()) in.fail(key, fmt::format("expected an array, found {}", list.type_name()));
  if (list.size() > leases_per_message)
    in.fail(key,
            fmt::format("expected at most {} leases, found {}", leases_per_message, list.size()));
  return list;
}

Hello hello_from(ObjectReader& in) {
  Hello m;
  m.token = text_from(in, "token", short_most);
  m.name = in.text("name");
  if (!is_plain_name(m.name)) in.fail("name", "expected 1 to 128 bytes without control characters");
  m.identity = in.text("identity");
  if (m.identity.size() != 32 ||
      m.identity.find_first_not_of("0123456789abcdef") != std::string::npos)
    in.fail("identity", "expected 32 lower-case hexadecimal digits");
  m.threads = static_cast<int>(in.integer("threads", 1, 65536));
  m.build_id = digest_from(in, "build_id");
  m.version = text_from(in, "version", 128);
  return m;
}

Welcome welcome_from(ObjectReader& in) {
  Welcome m;
  m.worker = unsigned_from(in, "worker");
  m.epoch = unsigned_from(in, "epoch");
  m.heartbeat_ms = static_cast<int>(in.integer("heartbeat_ms", 10, 3'600'000));
  m.blob_url = text_from(in, "blob_url", 1024);
  m.blob_token = text_from(in, "blob_token", short_most);
  return m;
}

Assign assign_from(ObjectReader& in) {
  Assign m;
  m.lease = lease_from(in);
  m.job = unsigned_from(in, "job", 1);
  m.plan = digest_from(in, "plan");
  m.task = task_from(in);
  if (const Json* spec = in.optional("spec"))
    m.spec = job_spec_from_json(*spec, in.path_of("spec"));
  return m;
}

Progress progress_from(ObjectReader& in) {
  Progress m;
  for (const Json& one : list_from(in, "running")) {
    expect_array(one, 3, "a running lease as [epoch, number, fraction]", in, "running");
    m.running.push_back({.lease = {.epoch = unsigned_in(one[0], 0, in, "running"),
                                   .number = unsigned_in(one[1], 0, in, "running")},
                         .fraction = fraction_in(one[2], in, "running")});
  }
  if (const Json* cache = in.optional("cache")) {
    expect_array(*cache, 3, "what the cache holds as [bytes, most, evictions]", in, "cache");
    m.cache = CacheUse{.bytes = unsigned_in((*cache)[0], 0, in, "cache"),
                       .most = unsigned_in((*cache)[1], 0, in, "cache"),
                       .evictions = unsigned_in((*cache)[2], 0, in, "cache")};
  }
  return m;
}

Revoke revoke_from(ObjectReader& in) {
  Revoke m;
  for (const Json& one : list_from(in, "leases")) m.leases.push_back(lease_in(one, in, "leases"));
  m.reason = reason_from(in);
  return m;
}

Result result_from(ObjectReader& in) {
  Result m;
  m.lease = lease_from(in);
  m.job = unsigned_from(in, "job", 1);
  m.plan = digest_from(in, "plan");
  m.task = task_from(in);
  m.samples = in.integer("samples", 0, INT64_MAX);
  m.rays = in.integer("rays", 0, INT64_MAX);
  m.rejected = in.integer("rejected", 0, INT64_MAX);
  m.seconds = in.number("seconds", 0, seconds_most);
  m.cpu_seconds = in.number("cpu_seconds", 0, seconds_most);
  return m;
}

Failed failed_from(ObjectReader& in) {
  Failed m;
  m.job = unsigned_from(in, "job", 1);
  if (const Json* lease = in.optional("lease")) m.lease = lease_in(*lease, in, "lease");
  m.code = text_from(in, "code", 64);
  m.reason = reason_from(in);
  if (in.optional("log") != nullptr) m.log = text_from(in, "log", log_most);
  return m;
}

Message message_from(std::uint16_t type, ObjectReader& in) {
  switch (type) {
    case 1:
      return hello_from(in);
    case 2:
      return welcome_from(in);
    case 3:
      return Refused{.code = text_from(in, "code", 64), .reason = reason_from(in)};
    case 4:
      return assign_from(in);
    case 5:
      return Preparing{.job = unsigned_from(in, "job", 1),
                       .fraction = fraction_in(in.required("fraction"), in, "fraction")};
    case 6:
      return Ready{.job = unsigned_from(in, "job", 1)};
    case 7:
      return progress_from(in);
    case 8:
      return revoke_from(in);
    case 9:
      return result_from(in);
    case 10:
      return Accepted{.lease = lease_from(in)};
    case 11:
      return Stale{.lease = lease_from(in)};
    case 12:
      return Rejected{.lease = lease_from(in), .reason = reason_from(in)};
    case 13:
      return failed_from(in);
    case 14:
      return Drain{.reason = reason_from(in)};
    case 15:
      return Bye{.reason = reason_from(in)};
    default:
      break;
  }
  throw Error(ErrorKind::bad_input, fmt::format("unknown message type {}", type));
}
}  // namespace

Message decode(std::uint16_t type, std::string_view header) {
  const std::string_view name = name_of(type);
  if (name.empty()) throw Error(ErrorKind::bad_input, fmt::format("unknown message type {}", type));
  const Json json = parse_json(header, name);
  ObjectReader in(json, std::string(name));
  return message_from(type, in);
}

}  // namespace tessera::wire
