#include "common/assets/blob_store.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/random.hpp"

namespace tessera::assets {
namespace {

namespace fs = std::filesystem;

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text));
}

class BlobStoreTest : public testing::Test {
 protected:
  fs::path folder = fs::path(testing::TempDir()) / ("blobs-" + random_hex(6));
  BlobStore store{folder};
  ~BlobStoreTest() override { fs::remove_all(folder); }

  static ErrorKind kind_of(const std::function<void()>& call) {
    try {
      call();
    } catch (const Error& error) {
      return error.kind();
    }
    ADD_FAILURE() << "no error";
    return ErrorKind::failed;
  }
  static std::size_t files_in(const fs::path& where) {
    std::size_t count = 0;
    for ([[maybe_unused]] const auto& entry : fs::directory_iterator(where)) ++count;
    return count;
  }
  static EvictionRule unused_for(int seconds) {
    return {.young = fs::file_time_type::clock::now() - std::chrono::seconds(seconds)};
  }
  void used_ago(const Digest& digest, int seconds) {
    fs::last_write_time(store.path(digest),
                        fs::file_time_type::clock::now() - std::chrono::seconds(seconds));
  }
};

TEST_F(BlobStoreTest, what_is_put_is_found_by_its_digest) {
  const Digest digest = store.put(bytes_of("hello"));
  EXPECT_EQ(digest, digest_of("hello"));
  EXPECT_TRUE(store.has(digest));
  EXPECT_EQ(store.size(digest), 5U);
  EXPECT_EQ(store.read(digest, 5), "hello");
  EXPECT_EQ(kind_of([&] { (void)store.read(digest, 4); }), ErrorKind::too_large);
  EXPECT_EQ(store.path(digest), folder / digest.hex().substr(0, 2) / digest.hex().substr(2));
  const Digest other = digest_of("other");
  EXPECT_FALSE(store.has(other));
  EXPECT_EQ(kind_of([&] { (void)store.read(other, 4); }), ErrorKind::not_found);
  const std::vector<Digest> both{other, digest};
  EXPECT_EQ(store.missing(both), std::vector<Digest>{other});
}

TEST_F(BlobStoreTest, it_finds_its_blobs_again_when_opened_anew) {
  const Digest digest = store.put(bytes_of("hello"));
  BlobStore again(folder);
  EXPECT_EQ(again.read(digest, 100), "hello");
}

TEST_F(BlobStoreTest, an_upload_in_pieces_can_be_resumed) {
  const std::string text(100000, 'x');
  const Digest digest = digest_of(text);
  EXPECT_EQ(store.append(digest, 0, bytes_of(text.substr(0, 60000))), 60000U);
  EXPECT_FALSE(store.has(digest));
  {
    BlobStore restarted(folder);
    EXPECT_EQ(restarted.partial_size(digest), 60000U);
  }
  EXPECT_EQ(kind_of([&] { store.append(digest, 0, bytes_of("again")); }), ErrorKind::conflict);
  EXPECT_EQ(kind_of([&] { store.append(digest, 60001, bytes_of("gap")); }), ErrorKind::conflict);
  store.append(digest, 60000, bytes_of(text.substr(60000)));
  store.finish(digest);
  EXPECT_EQ(store.read(digest, text.size()), text);
  EXPECT_EQ(store.partial_size(digest), 0U);
  store.finish(digest);  // already here: nothing happens
}

TEST_F(BlobStoreTest, an_upload_of_other_bytes_is_refused_and_can_begin_anew) {
  const Digest digest = digest_of("right");
  store.append(digest, 0, bytes_of("wrong"));
  EXPECT_EQ(kind_of([&] { store.finish(digest); }), ErrorKind::bad_input);
  EXPECT_FALSE(store.has(digest));
  EXPECT_EQ(store.partial_size(digest), 0U);
  store.append(digest, 0, bytes_of("right"));
  store.finish(digest);
  EXPECT_TRUE(store.has(digest));
}

TEST_F(BlobStoreTest, an_empty_blob_is_a_blob) {
  const Digest digest = digest_of("");
  store.finish(digest);
  EXPECT_EQ(store.size(digest), 0U);
}

TEST_F(BlobStoreTest, a_writer_that_is_dropped_or_wrong_leaves_nothing) {
  const Digest digest = digest_of("right");
  {
    BlobStore::Writer writer = store.writer(digest);
    writer.write(bytes_of("rig"));
    EXPECT_EQ(files_in(folder / "tmp"), 1U);
  }
  {
    BlobStore::Writer writer = store.writer(digest);
    writer.write(bytes_of("wrong"));
    EXPECT_EQ(kind_of([&] { writer.commit(); }), ErrorKind::bad_input);
  }
  EXPECT_EQ(files_in(folder / "tmp"), 0U);
  EXPECT_FALSE(store.has(digest));
  BlobStore::Writer writer = store.writer(digest);
  writer.write(bytes_of("ri"));
  writer.write(bytes_of("ght"));
  EXPECT_EQ(writer.size(), 5U);
  writer.commit();
  EXPECT_EQ(store.read(digest, 5), "right");
}

TEST_F(BlobStoreTest, many_threads_may_put_the_same_blobs) {
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i)
    threads.emplace_back([this] {
      BlobStore mine(folder, false);
      for (int n = 0; n < 50; ++n)
        mine.put(bytes_of(std::string(1000, static_cast<char>('a' + n % 10))));
    });
  for (std::thread& thread : threads) thread.join();
  for (char c = 'a'; c < 'k'; ++c) EXPECT_TRUE(store.verify(digest_of(std::string(1000, c))));
  EXPECT_EQ(files_in(folder / "tmp"), 0U);
}

TEST_F(BlobStoreTest, two_who_upload_the_same_blob_by_offset_help_each_other) {
  const std::string text(64000, 'z');
  const Digest digest = digest_of(text);
  const auto upload = [&] {
    while (!store.has(digest)) {
      const std::uint64_t at = store.partial_size(digest);
      if (at == text.size()) return;
      try {
        store.append(digest, at, bytes_of(text.substr(at, 1000)));
      } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::conflict);
      }
    }
  };
  std::thread other(upload);
  upload();
  other.join();
  store.finish(digest);
  EXPECT_EQ(store.read(digest, text.size()), text);
}

TEST_F(BlobStoreTest, a_damaged_blob_is_found_out_and_removed) {
  const Digest digest = store.put(bytes_of("hello"));
  EXPECT_TRUE(store.verify(digest));
  std::ofstream(store.path(digest)) << "hellp";
  EXPECT_FALSE(store.verify(digest));
  EXPECT_FALSE(store.has(digest));
  EXPECT_FALSE(store.verify(digest));
}

TEST_F(BlobStoreTest, old_partial_files_are_removed_and_young_ones_stay) {
  const Digest old_one = digest_of("old"), young = digest_of("young");
  store.append(old_one, 0, bytes_of("o"));
  store.append(young, 0, bytes_of("y"));
  fs::last_write_time(folder / "partial" / old_one.hex(),
                      fs::file_time_type::clock::now() - std::chrono::hours(2));
  store.remove_partials(3600);
  EXPECT_EQ(store.partial_size(old_one), 0U);
  EXPECT_EQ(store.partial_size(young), 1U);
}

TEST_F(BlobStoreTest, the_least_recently_used_go_first_and_only_as_many_as_must) {
  std::vector<Digest> blobs;
  for (char c = 'a'; c < 'e'; ++c) blobs.push_back(store.put(bytes_of(std::string(100, c))));
  for (int i = 0; i < 4; ++i) used_ago(blobs[static_cast<std::size_t>(i)], 100 - i);
  store.pin({blobs[0]}).reset();  // a pin counts as use
  EXPECT_EQ(store.evict(400).left, 400U);
  EXPECT_EQ(store.evict(250).left, 200U);
  EXPECT_TRUE(store.has(blobs[0]));
  EXPECT_FALSE(store.has(blobs[1]));
  EXPECT_FALSE(store.has(blobs[2]));
  EXPECT_TRUE(store.has(blobs[3]));
}

TEST_F(BlobStoreTest, pinned_blobs_are_never_evicted_not_even_by_another_store) {
  const Digest pinned = store.put(bytes_of("pinned")), loose = store.put(bytes_of("loose"));
  auto pin = store.pin({pinned});
  BlobStore other(folder, false);
  EXPECT_EQ(other.evict(0).left, 6U);
  EXPECT_TRUE(store.has(pinned));
  EXPECT_FALSE(store.has(loose));
  EXPECT_EQ(store.evict(0).left, 6U);
  pin.reset();
  EXPECT_EQ(other.evict(0).left, 0U);
  EXPECT_FALSE(store.has(pinned));
}

TEST_F(BlobStoreTest, pins_of_a_process_that_died_hold_nothing) {
  const Digest digest = store.put(bytes_of("blob"));
  // What a killed process leaves: its file of pins, whose lock is free.
  std::ofstream(folder / "pins" / "0123456789abcdef") << digest.hex() << '\n';
  EXPECT_EQ(store.evict(0).left, 0U);
  EXPECT_EQ(files_in(folder / "pins"), 0U);
}

TEST_F(BlobStoreTest, what_is_uploaded_again_or_made_whole_late_counts_as_new) {
  const Digest again = store.put(bytes_of("again")), old = store.put(bytes_of("old"));
  const Digest late = digest_of("late"), sent = store.put(bytes_of("sent"));
  store.append(late, 0, bytes_of("late"));
  fs::last_write_time(folder / "partial" / late.hex(),
                      fs::file_time_type::clock::now() - std::chrono::hours(2));
  for (const Digest& digest : {again, old, sent}) used_ago(digest, 7200);
  EXPECT_EQ(store.renew(again), 5U);
  EXPECT_EQ(store.renew(digest_of("nothing")), std::nullopt);
  store.put(bytes_of("sent"));
  store.finish(late);
  EXPECT_EQ(store.collect({}, unused_for(3600)).bytes, 3U);
  EXPECT_FALSE(store.has(old));
  for (const Digest& digest : {again, late, sent}) EXPECT_TRUE(store.has(digest));
}

TEST_F(BlobStoreTest, many_are_collected_but_none_that_is_needed_or_pinned) {
  std::vector<Digest> blobs;
  for (int i = 0; i < 300; ++i) blobs.push_back(store.put(bytes_of("blob " + std::to_string(i))));
  const auto pin = store.pin({blobs[7]});
  for (const Digest& digest : blobs) used_ago(digest, 7200);
  EXPECT_EQ(store.collect({blobs[11], blobs[299]}, unused_for(3600)).blobs, 297U);
  for (std::size_t i = 0; i < blobs.size(); ++i)
    EXPECT_EQ(store.has(blobs[i]), i == 7 || i == 11 || i == 299) << i;
}

TEST_F(BlobStoreTest, uploads_that_broke_off_are_collected_with_what_nobody_needs) {
  const Digest blob = store.put(bytes_of(std::string(100, 'b')));
  const Digest upload = digest_of("upload"), young = digest_of("young");
  store.append(upload, 0, bytes_of("uplo"));
  store.append(young, 0, bytes_of("you"));
  used_ago(blob, 7200);
  fs::last_write_time(folder / "partial" / upload.hex(),
                      fs::file_time_type::clock::now() - std::chrono::hours(3));
  EvictionRule rule = unused_for(3600);
  rule.most = 103;
  const BlobStore::Evicted evicted = store.collect({}, rule);
  EXPECT_EQ(evicted.blobs, 1U);
  EXPECT_EQ(evicted.bytes, 4U);
  EXPECT_EQ(evicted.left, 103U);
  EXPECT_EQ(store.partial_size(upload), 0U);
  EXPECT_EQ(store.partial_size(young), 3U);
  rule.most = 0;
  EXPECT_EQ(store.collect({blob}, rule).left, 3U) << "what is needed is not counted";
  EXPECT_TRUE(store.has(blob));
}

TEST_F(BlobStoreTest, a_folder_that_cannot_be_made_is_named) {
  std::ofstream(folder / "file") << "x";
  try {
    BlobStore bad(folder / "file" / "store");
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr((folder / "file" / "store").string()));
  }
}

}  // namespace
}  // namespace tessera::assets
