// What a peer may do wrongly on either port: each is answered as it should be, and the farm's
// process, its other jobs and its memory stay as they were.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "common/image/tile.hpp"
#include "common/wire/codec.hpp"
#include "tests/farm/farm.hpp"
#include "tests/farm/scripted_worker.hpp"
#include "tests/support/sanitized.hpp"

namespace tessera::farm_test {
namespace {

/// How much the coordinator may grow by what one peer does to it, MiB.
constexpr double growth_most = sanitized ? 512 : 64;

/// A farm with a job under way, which has to come out right whatever the test did to the ports.
class BadPeer : public testing::Test {
 protected:
  void SetUp() override {
    id_ = farm_.submit((sources() / "scenes/cornell.json").string(),
                       {"--size", "48x40", "--samples", "20", "--tile", "16"});
    ASSERT_FALSE(id_.empty());
    farm_.server().forget_peak_memory();
    memory_before_ = farm_.server().peak_memory();
  }

  void TearDown() override {
    if (HasFatalFailure()) return;
    ASSERT_TRUE(farm_.server().running()) << farm_.logs();
    ASSERT_GT(memory_before_, 0);
    EXPECT_LT(farm_.server().peak_memory(), memory_before_ + growth_most);
    farm_.add_worker();
    const image::ExrImage picture = farm_.finish(id_);
    const auto different = image::difference(undisturbed(), picture);
    EXPECT_FALSE(different.has_value()) << different.value_or("");
  }

  static const image::ExrImage& undisturbed() {
    static const image::ExrImage picture = [] {
      Farm farm;
      farm.add_worker();
      return farm.finish(farm.submit((sources() / "scenes/cornell.json").string(),
                                     {"--size", "48x40", "--samples", "20", "--tile", "16"}));
    }();
    return picture;
  }

  /// What the HTTP port answers to these bytes.
  std::string http(const std::string& request, Seconds most = Seconds(5)) {
    const Line line(farm_.http());
    EXPECT_TRUE(line.send(request));
    return line.receive_all(most);
  }

  Farm farm_;
  std::string id_;
  double memory_before_ = 0;
};

std::string random_bytes(std::size_t count) {
  std::string bytes(count, '\0');
  std::uint64_t state = 88172645463325252ULL;
  for (char& byte : bytes) {
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    byte = static_cast<char>(state >> 56);
  }
  return bytes;
}

void expect_rejected(const std::optional<wire::Message>& answer,
                     const std::vector<std::string>& texts) {
  ASSERT_TRUE(answer.has_value()) << "no answer";
  const auto* rejected = std::get_if<wire::Rejected>(&*answer);
  ASSERT_NE(rejected, nullptr) << "answered with message " << wire::name_of(wire::type_of(*answer));
  for (const std::string& text : texts)
    EXPECT_NE(rejected->reason.find(text), std::string::npos)
        << "no \"" << text << "\" in: " << rejected->reason;
}

image::TileImage tile_of(const AssignedTask& task) {
  const auto exr = ScriptedWorker::good_tile(task);
  image::TileExpectation expected;
  expected.window = task.plan.grid.tile(task.assign.task.tile);
  expected.film_width = task.plan.grid.film_width();
  expected.film_height = task.plan.grid.film_height();
  expected.samples = static_cast<std::uint32_t>(task.plan.passes.pass(task.assign.task.pass).count);
  expected.aovs = task.plan.passes.has_aovs(task.assign.task.pass, task.plan.spec.aov_samples);
  return image::decode_tile(exr, expected);
}

// ---- the workers' port ----

TEST_F(BadPeer, http_at_the_workers_port_is_told_so) {
  const Line line(farm_.listen());
  line.send("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
  const std::string answer = line.receive_all(Seconds(8));
  EXPECT_NE(answer.find("HTTP"), std::string::npos) << "it should say what it was sent: " << answer;
}

TEST_F(BadPeer, garbage_at_the_workers_port_ends_the_connection) {
  const Line line(farm_.listen());
  line.send(random_bytes(100'000));
  EXPECT_TRUE(line.closed_within(Seconds(8)));
}

TEST_F(BadPeer, half_a_frame_and_silence_is_cut_off) {
  const Line line(farm_.listen());
  line.send("TSRA\x01");
  EXPECT_TRUE(line.closed_within(Seconds(15)));
}

TEST_F(BadPeer, a_length_beyond_all_limits_is_refused_and_not_reserved) {
  const Line line(farm_.listen());
  std::string head("TSRA\x01\0\x01\0", 8);  // version 1, hello
  head += std::string(8, '\xff');           // lengths of header and body
  line.send(head + "{");
  EXPECT_TRUE(line.closed_within(Seconds(8)));
}

TEST_F(BadPeer, half_a_result_of_a_welcomed_worker_is_cut_off) {
  ScriptedWorker worker(farm_.listen());
  auto task = worker.next_task();
  ASSERT_TRUE(task.has_value());
  const auto encoded = wire::encode(ScriptedWorker::result_of(*task));
  const auto bytes =
      wire::frame_bytes(encoded.type, encoded.header, ScriptedWorker::good_tile(*task));
  worker.line().send(std::span(bytes).first(bytes.size() / 2));
  EXPECT_TRUE(worker.line().closed_within(Seconds(15)));
  // Its task goes out again, or the job would not come to its end.
}

TEST_F(BadPeer, another_protocol_version_is_refused_with_both_versions) {
  const Line line(farm_.listen());
  wire::Hello hello;
  hello.identity = "00112233445566778899aabbccddeeff";
  const auto encoded = wire::encode(hello);
  auto bytes = wire::frame_bytes(encoded.type, encoded.header);
  bytes[4] = std::byte{99};  // little-endian version, behind the magic
  line.send(bytes);
  const std::string answer = line.receive_all(Seconds(8));
  EXPECT_NE(answer.find("version"), std::string::npos) << answer;
  EXPECT_NE(answer.find("99"), std::string::npos) << answer;
}

TEST_F(BadPeer, a_message_before_hello_ends_the_connection) {
  const Line line(farm_.listen());
  const auto encoded = wire::encode(wire::Bye{"too early"});
  line.send(wire::frame_bytes(encoded.type, encoded.header));
  EXPECT_TRUE(line.closed_within(Seconds(8)));
}

TEST_F(BadPeer, a_tile_of_the_wrong_size_is_rejected) {
  ScriptedWorker worker(farm_.listen());
  ASSERT_TRUE(worker.welcomed());
  auto task = worker.next_task();
  ASSERT_TRUE(task.has_value());
  image::TileImage tile = tile_of(*task);
  tile.window.width -= 1;
  tile.values.resize(tile.channels() * tile.pixels());
  expect_rejected(worker.deliver(ScriptedWorker::result_of(*task), image::encode_tile(tile)),
                  {"window"});
}

TEST_F(BadPeer, a_tile_with_nan_is_rejected) {
  ScriptedWorker worker(farm_.listen());
  auto task = worker.next_task();
  ASSERT_TRUE(task.has_value());
  image::TileImage tile = tile_of(*task);
  tile.values[5] = std::numeric_limits<float>::quiet_NaN();
  expect_rejected(worker.deliver(ScriptedWorker::result_of(*task), image::encode_tile(tile)),
                  {"finite"});
}

TEST_F(BadPeer, a_broken_exr_is_rejected) {
  ScriptedWorker worker(farm_.listen());
  auto task = worker.next_task();
  ASSERT_TRUE(task.has_value());
  auto exr = ScriptedWorker::good_tile(*task);
  exr.resize(exr.size() / 2);
  expect_rejected(worker.deliver(ScriptedWorker::result_of(*task), exr), {"not a valid EXR"});
}

TEST_F(BadPeer, a_tile_with_another_sample_count_is_rejected) {
  ScriptedWorker worker(farm_.listen());
  auto task = worker.next_task();
  ASSERT_TRUE(task.has_value());
  image::TileImage tile = tile_of(*task);
  tile.samples[0] += 1;
  expect_rejected(worker.deliver(ScriptedWorker::result_of(*task), image::encode_tile(tile)),
                  {"samples"});
}

TEST_F(BadPeer, a_result_for_a_task_it_never_held_is_rejected) {
  ScriptedWorker holder(farm_.listen());
  auto task = holder.next_task();
  ASSERT_TRUE(task.has_value());
  ScriptedHello hello;
  hello.identity = "ffeeddccbbaa99887766554433221100";
  ScriptedWorker stranger(farm_.listen(), hello);
  ASSERT_TRUE(stranger.welcomed());
  expect_rejected(
      stranger.deliver(ScriptedWorker::result_of(*task), ScriptedWorker::good_tile(*task)),
      {"granted"});
}

// ---- the people's port ----

TEST_F(BadPeer, garbage_at_the_http_port_is_answered_or_cut_off) {
  const Line line(farm_.http());
  line.send(random_bytes(100'000));
  EXPECT_TRUE(line.closed_within(Seconds(8)));
}

TEST_F(BadPeer, a_page_from_another_origin_is_refused) {
  const std::string answer = http("GET /v1/jobs HTTP/1.1\r\nHost: " + farm_.http() +
                                  "\r\nOrigin: https://evil.example\r\nConnection: close\r\n\r\n");
  EXPECT_TRUE(answer.starts_with("HTTP/1.1 403")) << answer;
  EXPECT_NE(answer.find("application/problem+json"), std::string::npos) << answer;
  EXPECT_EQ(answer.find("Access-Control-Allow-Origin"), std::string::npos) << answer;
}

TEST_F(BadPeer, another_host_name_is_refused) {
  const std::string answer =
      http("GET /v1/jobs HTTP/1.1\r\nHost: evil.example\r\nConnection: close\r\n\r\n");
  EXPECT_TRUE(answer.starts_with("HTTP/1.1 421")) << answer;
}

TEST_F(BadPeer, a_client_that_does_not_read_holds_nothing_up) {
  const Line line(farm_.http());
  const std::string get =
      "GET /v1/jobs/" + id_ + "/frames/1/image.exr HTTP/1.1\r\nHost: " + farm_.http() + "\r\n\r\n";
  for (int k = 0; k < 2000; ++k)
    if (!line.send(get)) break;
  const std::string other =
      http("GET /healthz HTTP/1.1\r\nHost: " + farm_.http() + "\r\nConnection: close\r\n\r\n");
  EXPECT_TRUE(other.starts_with("HTTP/1.1 200")) << other;
}

TEST_F(BadPeer, a_job_of_nonsense_is_a_problem_with_its_place) {
  const std::string body = R"({"name": "x", "name": "y"})";
  const std::string answer =
      http("POST /v1/jobs HTTP/1.1\r\nHost: " + farm_.http() +
           "\r\nContent-Type: application/json\r\nContent-Length: " + std::to_string(body.size()) +
           "\r\nConnection: close\r\n\r\n" + body);
  EXPECT_TRUE(answer.starts_with("HTTP/1.1 400")) << answer;
  EXPECT_NE(answer.find("twice"), std::string::npos) << answer;
}

}  // namespace
}  // namespace tessera::farm_test
