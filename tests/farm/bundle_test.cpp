// What goes over of a scene's files: each byte once, whatever breaks off, in little memory.
#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/base/digest.hpp"
#include "tests/farm/farm.hpp"
#include "tests/farm/large_scene.hpp"
#include "tests/farm/scripted_worker.hpp"
#include "tests/support/sanitized.hpp"

namespace tessera::farm_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* received = "tessera_blob_bytes_received_total";
constexpr double list_of_files = 16 * 1024;  // bytes, at most

/// The beginning of a file, as an upload that breaks off sends it.
void begin_upload(const Farm& farm, const fs::path& file, std::size_t bytes) {
  const Line line(farm.http());
  line.send("PUT /v1/blobs/" + digest_of_file(file).hex() + " HTTP/1.1\r\nHost: " + farm.http() +
            "\r\nContent-Length: " + std::to_string(fs::file_size(file)) + "\r\n\r\n");
  std::string text(bytes, '\0');
  std::ifstream(file, std::ios::binary).read(text.data(), static_cast<std::streamsize>(bytes));
  line.send(text);
}

/// What is kept of uploads that broke off, bytes.
std::uintmax_t kept(const Farm& farm) {
  std::uintmax_t total = 0;
  for (const auto& entry : fs::directory_iterator(farm.folder() / "data" / "blobs" / "partial")) {
    std::error_code gone;
    const std::uintmax_t size = entry.file_size(gone);
    if (!gone) total += size;
  }
  return total;
}

/// Looked at often: what a test waits for passes by.
bool soon(const std::function<bool()>& holds) {
  return becomes_true(holds, Seconds(60), std::chrono::milliseconds(1));
}

TEST(Bundle, a_scene_goes_over_once_and_the_second_submission_sends_nothing) {
  Farm farm;
  const LargeScene scene(farm.folder().path(), {.pictures = 5, .side = 512});
  farm.submit(scene.file(), {});
  const double first = farm.metric(received);
  EXPECT_GE(first, static_cast<double>(scene.bytes()));
  EXPECT_LT(first, static_cast<double>(scene.bytes()) + list_of_files);
  const Outcome again = farm.tessera({"submit", scene.file()});
  EXPECT_EQ(again.code, 0) << again.errors;
  EXPECT_EQ(farm.metric(received), first);
  EXPECT_NE(again.errors.find("nothing to send"), std::string::npos) << again.errors;
}

TEST(Bundle, an_upload_that_broke_off_goes_on_where_it_was_also_after_the_coordinators_death) {
  Farm farm;
  const LargeScene scene(farm.folder().path(), {.pictures = 1, .side = 1024});
  const std::size_t begun = 2'000'000;
  begin_upload(farm, scene.picture(0), begun);
  ASSERT_TRUE(soon([&] { return kept(farm) == begun; })) << kept(farm);
  farm.kill_and_restart_server();
  farm.submit(scene.file(), {});
  EXPECT_LT(farm.metric(received), static_cast<double>(scene.bytes() - begun) + list_of_files);
  EXPECT_EQ(kept(farm), 0U);
}

TEST(Bundle, a_submission_goes_on_though_the_coordinator_dies_meanwhile) {
  Farm farm;
  const LargeScene scene(farm.folder().path(), {.pictures = 2, .side = 4096});
  Process submit({(programs() / "tessera").string(), "--server", "http://" + farm.http(), "submit",
                  scene.file()},
                 farm.folder() / "submit");
  ASSERT_TRUE(soon([&] { return kept(farm) > 1'000'000; })) << submit.errors();
  submit.signal(SIGSTOP);
  farm.server().kill();
  const std::uintmax_t before = kept(farm);
  farm.start_killed_server();
  submit.signal(SIGCONT);
  EXPECT_EQ(submit.wait(Seconds(60)), 0) << submit.errors();
  EXPECT_GT(before, 0U) << "it came to its end too soon to say anything";
  EXPECT_LT(farm.metric(received), static_cast<double>(scene.bytes() - before) + list_of_files);
}

TEST(Bundle, two_who_send_the_same_scene_at_once_both_succeed) {
  Farm farm;
  const LargeScene scene(farm.folder().path(), {.pictures = 3, .side = 2048});
  std::vector<Process> clients;
  for (int i = 0; i < 3; ++i)
    clients.emplace_back(std::vector<std::string>{(programs() / "tessera").string(), "--server",
                                                  "http://" + farm.http(), "submit", scene.file()},
                         farm.folder() / ("client-" + std::to_string(i)));
  for (Process& client : clients) EXPECT_EQ(client.wait(Seconds(120)), 0) << client.errors();
  EXPECT_EQ(farm.get("/v1/jobs").at("jobs").size(), 3U);
}

TEST(Bundle, a_large_scene_goes_through_client_and_coordinator_in_little_memory) {
  Farm farm;
  constexpr double most = sanitized ? 512 : 100;  // MiB
  const LargeScene scene(farm.folder().path(), {.pictures = sanitized ? 60 : 25, .side = 2048});
  ASSERT_GT(static_cast<double>(scene.bytes()), 1.2 * most * (1 << 20));
  Process submit({(programs() / "tessera").string(), "--server", "http://" + farm.http(), "submit",
                  scene.file()},
                 farm.folder() / "submit");
  double client = 0;  // MiB
  while (submit.running()) {
    client = std::max(client, submit.peak_memory());
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_EQ(submit.wait(Seconds(0)), 0) << submit.errors();
  EXPECT_GT(client, 0);
  EXPECT_LT(client, most);
  EXPECT_LT(farm.server().peak_memory(), most);
}

std::size_t times(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
    ++count;
  return count;
}

TEST(Bundle, a_worker_fetches_and_builds_a_scene_once_whatever_the_number_of_tasks) {
  Farm farm;
  farm.add_worker();
  const LargeScene scene(farm.folder().path(), {.pictures = 2, .side = 256});
  const std::vector<std::string> many{"--size", "64x64", "--tile", "16", "--samples", "16"};
  const std::string first = farm.submit(scene.file(), many);
  farm.finish(first);
  EXPECT_GE(farm.job(first).at("tasks"), 16 * 3);
  EXPECT_EQ(times(farm.workers()[0].errors(), "scene built"), 1U) << farm.logs();
  farm.finish(farm.submit(scene.file(), many));
  EXPECT_EQ(times(farm.workers()[0].errors(), "scene built"), 1U) << "of the next job as well";
}

TEST(Bundle, a_workers_cache_keeps_to_its_limit_and_the_farm_says_what_it_holds) {
  Farm farm;
  farm.add_worker(1, {}, {"--cache-size", "0.002"});  // GiB: 2.1 MB
  std::vector<LargeScene> scenes;
  for (int i = 0; i < 4; ++i) {  // .8 MB each, no two pictures alike
    scenes.emplace_back(farm.folder() / std::to_string(i),
                        LargeSceneSettings{.pictures = 1, .side = 512 + i});
    farm.finish(farm.submit(scenes.back().file(), {}));
  }
  // Two scenes are kept ready, and what they read is pinned: the first one's went for the last's.
  EXPECT_TRUE(soon([&] { return farm.metric("tessera_worker_cache_evictions_total") > 0; }));
  EXPECT_GT(farm.metric("tessera_worker_cache_bytes"), 0);
  EXPECT_NEAR(farm.metric("tessera_worker_cache_limit_bytes"), 0.002 * (1 << 30), 1);
}

}  // namespace
}  // namespace tessera::farm_test
