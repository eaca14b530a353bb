#include "common/wire/codec.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/json.hpp"
#include "common/base/limits.hpp"

namespace tessera::wire {
namespace {

using testing::HasSubstr;
constexpr std::uint64_t most = UINT64_MAX;

JobSpec spec() {
  JobSpec job;
  job.name = "a job";
  job.bundle = digest_of("bundle");
  job.render.width = 640;
  job.render.height = 360;
  job.render.seed = (1ULL << 53) + 1;  // not a double
  return job;
}

/// One of each message, with the values that are hardest to carry.
std::vector<Message> samples() {
  const LeaseId lease{.epoch = most, .number = most - 1};
  const TaskId task{.frame = INT32_MIN, .tile = UINT32_MAX, .pass = 7};
  return {
      Hello{.token = "t",
            .name = "wörker",
            .identity = std::string(32, 'a'),
            .threads = 12,
            .build_id = digest_of("b"),
            .version = "0.1.0"},
      Welcome{.worker = most,
              .epoch = (1ULL << 53) + 1,
              .heartbeat_ms = 250,
              .blob_url = "http://[::1]:8420",
              .blob_token = "x"},
      Refused{.code = "token", .reason = "the token is not the one that this server wants"},
      Assign{.lease = lease, .job = most, .plan = digest_of("p"), .task = task, .spec = spec()},
      Preparing{.job = 3, .fraction = 1.0 / 3},
      Ready{.job = 4},
      Progress{.running = {{.lease = lease, .fraction = 0.1},
                           {.lease = {.epoch = 1, .number = 2}, .fraction = 1}},
               .cache = CacheUse{.bytes = most, .most = 1, .evictions = 0}},
      Revoke{.leases = {lease, {.epoch = 0, .number = 0}}, .reason = "cancelled"},
      Result{.lease = lease,
             .job = 9,
             .plan = digest_of("q"),
             .task = task,
             .samples = INT64_MAX,
             .rays = (1LL << 53) + 1,
             .rejected = 1,
             .seconds = 0.1,
             .cpu_seconds = 1e-300},
      Accepted{.lease = lease},
      Stale{.lease = lease},
      Rejected{.lease = lease, .reason = "NaN in channel R"},
      Failed{.job = 5, .lease = lease, .code = "render", .reason = "no memory", .log = "a\nb\n"},
      Drain{.reason = "restart"},
      Bye{.reason = "done"},
  };
}

/// Equality by what is written: every field of every message stands in its header.
std::string written(const Message& message) { return encode(message).header; }

std::string error_of(const Message& message, const std::function<void(Json&)>& change) {
  const EncodedMessage encoded = encode(message);
  Json json = Json::parse(encoded.header);
  change(json);
  try {
    decode(encoded.type, json.dump());
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::bad_input);
    return error.what();
  }
  return "taken";
}

TEST(Codec, there_is_a_sample_of_every_message) {
  std::set<std::uint16_t> types;
  for (const Message& message : samples()) types.insert(type_of(message));
  EXPECT_EQ(types.size(), message_types());
  EXPECT_EQ(*types.begin(), 1);
  EXPECT_EQ(*types.rbegin(), message_types());
}

TEST(Codec, every_message_comes_back_as_it_was) {
  for (const Message& message : samples()) {
    const EncodedMessage encoded = encode(message);
    const Message back = decode(encoded.type, encoded.header);
    EXPECT_EQ(back.index(), message.index());
    EXPECT_EQ(written(back), encoded.header);
  }
}

TEST(Codec, values_of_64_bits_survive) {
  const auto all = samples();
  const EncodedMessage result = encode(all[8]);
  const auto back = std::get<Result>(decode(result.type, result.header));
  EXPECT_EQ(back.lease.epoch, most);
  EXPECT_EQ(back.lease.number, most - 1);
  EXPECT_EQ(back.samples, INT64_MAX);
  EXPECT_EQ(back.rays, (1LL << 53) + 1);
  EXPECT_EQ(back.task.frame, INT32_MIN);
  EXPECT_EQ(back.task.tile, UINT32_MAX);
  EXPECT_EQ(back.cpu_seconds, 1e-300);
  const EncodedMessage assign = encode(all[3]);
  const auto assigned = std::get<Assign>(decode(assign.type, assign.header));
  EXPECT_EQ(assigned.job, most);
  ASSERT_TRUE(assigned.spec.has_value());
  EXPECT_EQ(*assigned.spec, spec());
}

TEST(Codec, every_key_but_those_that_may_lack_is_required_and_named_when_it_lacks) {
  for (const Message& message : samples()) {
    const Json json = Json::parse(encode(message).header);
    for (const auto& [key, value] : json.items()) {
      const std::string error =
          error_of(message, [&key = key](Json& header) { header.erase(key); });
      const bool optional =
          key == "spec" || key == "cache" ||
          ((key == "lease" || key == "log") && std::holds_alternative<Failed>(message));
      EXPECT_EQ(error == "taken", optional) << name_of(type_of(message)) << " " << key;
      if (!optional) {
        EXPECT_THAT(error, HasSubstr(key));
      }
    }
  }
}

TEST(Codec, every_key_of_the_wrong_type_is_named) {
  for (const Message& message : samples()) {
    const Json json = Json::parse(encode(message).header);
    for (const auto& [key, value] : json.items())
      for (const Json& wrong :
           {Json(true), Json(nullptr), Json::object(), Json(-1.5), Json::array({1, 2, 3, 4, 5})}) {
        const std::string error =
            error_of(message, [&key = key, &wrong](Json& header) { header[key] = wrong; });
        EXPECT_THAT(error, HasSubstr(key)) << name_of(type_of(message)) << " " << wrong.dump();
      }
  }
}

TEST(Codec, unknown_keys_are_ignored_but_not_in_a_spec) {
  for (const Message& message : samples())
    EXPECT_EQ(error_of(message, [](Json& header) { header["colour"] = "red"; }), "taken");
  const auto all = samples();
  EXPECT_THAT(error_of(all[3], [](Json& header) { header["spec"]["colour"] = "red"; }),
              HasSubstr("spec.colour"));
}

TEST(Codec, values_out_of_range_are_refused_by_name) {
  const auto all = samples();
  const auto expect_refused = [&](std::size_t message, const std::string& key, const Json& value) {
    EXPECT_THAT(error_of(all[message], [&](Json& header) { header[key] = value; }), HasSubstr(key))
        << value.dump();
  };
  expect_refused(0, "threads", 0);
  expect_refused(0, "identity", "ABC");
  expect_refused(0, "identity", std::string(32, 'G'));
  expect_refused(0, "build_id", "12");
  expect_refused(0, "name", "");
  expect_refused(0, "token", std::string(513, 'x'));
  expect_refused(1, "heartbeat_ms", 0);
  expect_refused(1, "worker", -1);
  expect_refused(1, "worker", 1e30);
  expect_refused(3, "job", 0);
  expect_refused(3, "task", Json::array({2147483648LL, 0, 0}));
  expect_refused(3, "task", Json::array({0, -1, 0}));
  expect_refused(3, "task", Json::array({0, 4294967296LL, 0}));
  expect_refused(3, "task", Json::array({0, most, 0}));
  expect_refused(3, "lease", Json::array({1}));
  expect_refused(3, "lease", Json::array({1, -1}));
  expect_refused(4, "fraction", 1.01);
  expect_refused(6, "running", Json::array({Json::array({1, 2, 3})}));
  expect_refused(8, "samples", -1);
  expect_refused(8, "seconds", -1);
  expect_refused(11, "reason", std::string(2049, 'x'));
}

TEST(Codec, a_header_that_is_no_json_object_is_refused) {
  for (const char* text :
       {"", "[]", "1", "{", "{\"job\":1,\"job\":2}", "{} {}", "\xff\xfe", "null"})
    EXPECT_THROW(decode(6, text), Error) << text;
  EXPECT_THROW(decode(6, std::string(200000, '[')), Error);
}

TEST(Codec, unknown_types_are_refused) {
  for (const std::uint16_t type : {0, 16, 255, 256, 65535})
    EXPECT_THROW(decode(type, "{}"), Error) << type;
  EXPECT_EQ(name_of(1), "hello");
  EXPECT_EQ(name_of(15), "bye");
  EXPECT_EQ(name_of(0), "");
  EXPECT_TRUE(has_body(9));
  EXPECT_FALSE(has_body(8));
}

TEST(Codec, long_and_broken_sentences_are_cut_and_mended) {
  std::string umlauts;
  for (int i = 0; i < 3000; ++i) umlauts += "ü";
  const EncodedMessage encoded = encode(Bye{.reason = umlauts});
  const auto bye = std::get<Bye>(decode(encoded.type, encoded.header));
  EXPECT_EQ(bye.reason, umlauts.substr(0, 2048));
  EXPECT_NO_THROW(decode(15, encode(Bye{.reason = "a\xff z"}).header));
  // However it is escaped, a refusal fits what is taken before the welcome.
  EXPECT_LE(encode(Refused{.code = "token", .reason = std::string(4000, '\x01')}).header.size(),
            limits::wire_header_before_welcome);
}

TEST(Codec, lists_of_leases_are_bounded_and_the_longest_fits_a_header) {
  Revoke revoke;
  revoke.leases.assign(leases_per_message, {.epoch = most, .number = most});
  const EncodedMessage encoded = encode(revoke);
  EXPECT_LE(encoded.header.size(), limits::wire_header);
  EXPECT_EQ(std::get<Revoke>(decode(encoded.type, encoded.header)).leases.size(),
            leases_per_message);
  revoke.leases.emplace_back();
  EXPECT_THROW(encode(revoke), Error);
}

TEST(Codec, changed_headers_are_refused_or_mean_something_but_never_crash) {
  std::mt19937 random(11);
  const auto all = samples();
  for (int round = 0; round < 5000; ++round) {
    const EncodedMessage encoded = encode(all[random() % all.size()]);
    std::string header = encoded.header;
    for (int change = 0; change < 3; ++change)
      header[random() % header.size()] = static_cast<char>(random() & 0xffU);
    try {
      EXPECT_EQ(type_of(decode(encoded.type, header)), encoded.type);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::bad_input);
    }
  }
}

}  // namespace
}  // namespace tessera::wire
