#include "worker/agent/fetch.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/random.hpp"
#include "tests/unit/agent/blob_server.hpp"

namespace tessera::agent {
namespace {

using namespace std::chrono_literals;

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text));
}

class FetchTest : public testing::Test {
 protected:
  std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / ("fetch-" + random_hex(6));
  assets::BlobStore cache{folder, false};
  FetchSettings settings{.patience = {.tries = 3, .first_wait = 1ms}};
  Fetcher fetcher{cache, settings};
  BlobServer server;
  std::vector<double> fractions;

  ~FetchTest() override { std::filesystem::remove_all(folder); }

  std::optional<FetchedBundle> fetch(const Digest& bundle, const std::string& token = "blobs",
                                     std::stop_token stop = {}) {
    return fetcher.fetch(
        bundle, server.url(), token, [this](double fraction) { fractions.push_back(fraction); },
        stop);
  }
  ErrorKind error_of(const Digest& bundle, const std::string& token = "blobs") {
    try {
      fetch(bundle, token);
    } catch (const Error& error) {
      return error.kind();
    }
    ADD_FAILURE() << "no error";
    return ErrorKind::conflict;
  }
};

TEST_F(FetchTest, a_bundle_and_its_files_come_once_and_are_found_by_path) {
  const Digest bundle = server.add_scene("{\"scene\":1}", std::string(200000, 'v'));
  const auto fetched = fetch(bundle);
  ASSERT_TRUE(fetched);
  EXPECT_EQ(fetched->bundle.scene, "scene.json");
  ASSERT_EQ(fetched->files.size(), 2U);
  std::ifstream in(fetched->files.at("scene.json"));
  const std::string text((std::istreambuf_iterator<char>(in)), {});
  EXPECT_EQ(text, "{\"scene\":1}");
  EXPECT_EQ(std::filesystem::file_size(fetched->files.at("meshes/a.obj")), 200000U);
  EXPECT_EQ(fractions.back(), 1);
  EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
  const int requests = server.requests;
  EXPECT_TRUE(fetch(bundle));
  EXPECT_EQ(server.requests, requests) << "all was in the cache";
}

TEST_F(FetchTest, another_process_finds_the_cache_but_reads_it_through) {
  const Digest bundle = server.add_scene("a", "bb");
  fetch(bundle);
  const int requests = server.requests;
  std::ofstream(cache.path(digest_of("bb"))) << "xx";  // damaged on disk
  Fetcher later(cache, settings);
  const auto fetched = later.fetch(bundle, server.url(), "blobs", [](double) {}, {});
  ASSERT_TRUE(fetched);
  EXPECT_EQ(server.requests, requests + 1) << "the damaged one alone";
  EXPECT_EQ(digest_of_file(fetched->files.at("meshes/a.obj")), digest_of("bb"));
}

TEST_F(FetchTest, a_broken_connection_is_tried_again_but_not_for_ever) {
  const Digest bundle = server.add_scene("a", "b");
  server.break_next = 2;
  EXPECT_TRUE(fetch(bundle));
  EXPECT_EQ(server.requests, 5);
  const Digest other = server.add_scene("c", "d");
  server.break_next = 1000;
  EXPECT_EQ(error_of(other), ErrorKind::unreachable);
}

TEST_F(FetchTest, what_breaks_off_goes_on_where_it_was_as_often_as_it_gets_on) {
  const std::string mesh = "mesh" + std::string(1 << 20, 'm');
  const Digest bundle = server.add_scene("a", mesh);
  ASSERT_TRUE(fetch(server.add_scene("a", "b")));  // so that the mesh alone is cut
  cache.put(bytes_of(server.text_of(bundle)));
  server.body_bytes = 0;
  server.cut_next = 8;  // more often than it would be tried if nothing came
  ASSERT_TRUE(fetch(bundle));
  EXPECT_EQ(server.body_bytes, mesh.size()) << "no byte came twice";
  EXPECT_EQ(digest_of_file(cache.path(digest_of(mesh))), digest_of(mesh));
}

TEST_F(FetchTest, a_server_that_knows_no_ranges_sends_all_again) {
  const std::string mesh(100'000, 'm');
  const Digest bundle = server.add_scene("a", mesh);
  ASSERT_TRUE(fetch(server.add_scene("a", "b")));  // so that the mesh alone is cut
  cache.put(bytes_of(server.text_of(bundle)));
  server.knows_ranges = false;
  server.cut_next = 1;
  ASSERT_TRUE(fetch(bundle));
  EXPECT_EQ(digest_of_file(cache.path(digest_of(mesh))), digest_of(mesh));
}

TEST_F(FetchTest, many_files_come_several_at_once_and_each_once) {
  assets::Bundle bundle;
  bundle.scene = "0";
  for (int i = 0; i < 100; ++i) {
    const std::string text = "file " + std::to_string(i / 2);
    bundle.files[std::to_string(i)] = {.digest = server.add(text), .size = text.size()};
  }
  const auto fetched = fetch(server.add(assets::canonical_json(bundle)));
  ASSERT_TRUE(fetched);
  EXPECT_EQ(server.requests, 1 + 50);
  for (const auto& [path, file] : fetched->files)
    EXPECT_EQ(digest_of_file(file), bundle.files.at(path).digest) << path;
}

TEST_F(FetchTest, what_will_not_change_is_not_tried_again) {
  const Digest bundle = server.add_scene("a", "b");
  EXPECT_EQ(error_of(bundle, "wrong"), ErrorKind::refused);
  EXPECT_EQ(error_of(digest_of("nowhere")), ErrorKind::not_found);
  EXPECT_EQ(server.requests, 2);
}

TEST_F(FetchTest, other_bytes_than_the_digest_says_are_never_taken) {
  const Digest bundle = server.add_scene("a", "mesh");
  server.answer_with(digest_of("mesh"), "hsem");
  EXPECT_EQ(error_of(bundle), ErrorKind::bad_input);
  EXPECT_FALSE(cache.has(digest_of("mesh")));
  server.answer_with(digest_of("mesh"), std::string(100, 'x'));
  EXPECT_EQ(error_of(bundle), ErrorKind::too_large) << "more than announced";
}

TEST_F(FetchTest, what_is_no_bundle_is_an_error) {
  EXPECT_EQ(error_of(server.add("{\"files\":{\"../a\":{}}}")), ErrorKind::bad_input);
}

TEST_F(FetchTest, a_stop_ends_it_without_an_error) {
  const Digest bundle = server.add_scene("a", "b");
  std::stop_source source;
  source.request_stop();
  EXPECT_FALSE(fetch(bundle, "blobs", source.get_token()));
}

TEST_F(FetchTest, room_is_made_before_anything_comes_and_the_oldest_go) {
  const auto made = [&](char letter) {
    return server.add_scene(std::string(1000, letter), std::string(4000, letter));
  };
  settings.cache_bytes = 12'000;
  Fetcher small(cache, settings);
  const auto fetch_and_forget = [&](const Digest& bundle) {
    small.fetch(bundle, server.url(), "blobs", [](double) {}, {});
    return cache.bytes();
  };
  const Digest first = made('1'), second = made('2'), third = made('3');
  fetch_and_forget(first);
  EXPECT_GT(fetch_and_forget(second), 10'000U) << "there is room for two";
  fetch_and_forget(first);
  EXPECT_LE(fetch_and_forget(third), 12'000U);
  EXPECT_TRUE(cache.has(digest_of(std::string(4000, '1'))));
  EXPECT_FALSE(cache.has(digest_of(std::string(4000, '2')))) << "it was used longest ago";
}

TEST_F(FetchTest, what_is_fetched_stays_as_long_as_it_is_held) {
  const Digest first = server.add_scene("a", "b");
  const Digest second = server.add_scene("c", "d");
  settings.cache_bytes = 0;
  Fetcher small(cache, settings);
  auto held = small.fetch(first, server.url(), "blobs", [](double) {}, {});
  auto next = small.fetch(second, server.url(), "blobs", [](double) {}, {});
  EXPECT_TRUE(cache.has(digest_of("a")));
  held.reset();
  cache.evict(0);
  EXPECT_FALSE(cache.has(digest_of("a")));
  EXPECT_TRUE(cache.has(digest_of("c")));
}

}  // namespace
}  // namespace tessera::agent
