// Scenes whose files are named by path: read where they lie, beneath the roots of each worker
// alone.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/farm/farm.hpp"
#include "tests/farm/large_scene.hpp"

namespace tessera::farm_test {
namespace {

namespace fs = std::filesystem;

std::string waits_for(const Farm& farm, const std::string& id) {
  const auto job = farm.job(id);
  const auto reason = job.find("waiting_for");
  return reason != job.end() && reason->is_string() ? reason->get<std::string>() : std::string();
}

TEST(ByPath, a_scene_that_is_named_by_path_sends_its_list_alone_and_has_the_same_bits) {
  Farm farm;
  const LargeScene scene(farm.folder().path(), {.pictures = 3, .side = 512});
  farm.add_worker(1, {}, {"--asset-root", farm.folder().path().string()});
  const std::string by_path = farm.submit(scene.file(), {"--by-path"});
  EXPECT_LT(farm.metric("tessera_blob_bytes_received_total"), 4096);
  const image::ExrImage named = farm.finish(by_path);
  const image::ExrImage sent = farm.finish(farm.submit(scene.file(), {}));
  const auto different = image::difference(named, sent);
  EXPECT_FALSE(different.has_value()) << different.value_or("");
}

TEST(ByPath, a_worker_without_the_root_refuses_and_another_that_has_it_renders) {
  Farm farm;
  const LargeScene scene(farm.folder().path(), {.pictures = 1, .side = 64});
  for (int i = 0; i < 3; ++i) farm.add_worker();
  ASSERT_TRUE(farm.wait_for_workers(3, Seconds(30)));
  const std::string id = farm.submit(scene.file(), {"--by-path"});
  ASSERT_TRUE(becomes_true([&] {
    return waits_for(farm, id).find("no connected worker can read its files") != std::string::npos;
  })) << farm.job(id).dump(2);
  EXPECT_NE(waits_for(farm, id).find("--asset-root"), std::string::npos);
  EXPECT_NE(farm.job(id).at("state"), "failed");
  farm.add_worker(1, {}, {"--asset-root", farm.folder().path().string()});
  farm.finish(id);
  EXPECT_EQ(farm.get("/v1/jobs/" + id + "/failures").at("count"), 3);
}

TEST(ByPath, a_file_that_was_changed_since_fails_the_job_with_its_name) {
  Farm farm;
  const LargeScene scene(farm.folder().path(), {.pictures = 1, .side = 64});
  const std::string id = farm.submit(scene.file(), {"--by-path"});
  std::ofstream(scene.picture(0), std::ios::app) << "more";
  farm.add_worker(1, {}, {"--asset-root", farm.folder().path().string()});
  EXPECT_EQ(farm.tessera({"wait", id}).code, 1);
  const std::string error = farm.job(id).at("error");
  EXPECT_NE(error.find(scene.picture(0).string()), std::string::npos) << error;
  EXPECT_NE(error.find("changed since it was submitted"), std::string::npos) << error;
}

TEST(ByPath, a_link_that_leads_out_of_the_root_is_not_followed) {
  Farm farm;
  const LargeScene scene(farm.folder() / "outside", {.pictures = 1, .side = 64});
  const fs::path root = farm.folder() / "root";
  fs::create_directories(root);
  fs::create_directory_symlink(fs::path(scene.file()).parent_path(), root / "scene");
  farm.add_worker(1, {}, {"--asset-root", root.string()});
  const std::string id = farm.submit((root / "scene" / "scene.json").string(), {"--by-path"});
  ASSERT_TRUE(becomes_true([&] { return !waits_for(farm, id).empty(); }));
  ASSERT_TRUE(becomes_true([&] {
    return waits_for(farm, id).find("a link in its path leads out") != std::string::npos;
  })) << waits_for(farm, id);
}

}  // namespace
}  // namespace tessera::farm_test
