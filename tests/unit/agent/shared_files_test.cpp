#include "worker/agent/shared_files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <optional>
#include <string>

#include "common/base/random.hpp"

namespace tessera::agent {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class SharedFilesTest : public testing::Test {
 protected:
  SharedFilesTest() {
    fs::create_directories(root / "textures");
    fs::create_directories(folder / "secret");
  }
  ~SharedFilesTest() override { fs::remove_all(folder); }

  fs::path folder = fs::canonical(testing::TempDir()) / ("shared-" + random_hex(6));
  fs::path root = folder / "show";
  SharedFiles files{{root}};
  int files_read = 0;

  static fs::path write(const fs::path& file, const std::string& text) {
    std::ofstream(file) << text;
    return file;
  }
  static assets::BundleFile entry(const fs::path& file, const std::string& text) {
    return {digest_of(text), text.size(), file.string()};
  }
  std::optional<SharedFile> open(const assets::BundleFile& one) {
    return files.open(one, [this](std::uint64_t) { ++files_read; }, {});
  }
  static std::string text_of(const SharedFile& file) {
    std::ifstream in(file.path());
    return {std::istreambuf_iterator<char>(in), {}};
  }
  /// Why this machine has it not; empty: it has.
  std::string why_not_here(const assets::BundleFile& one) {
    try {
      (void)open(one);
      return {};
    } catch (const FileNotHere& error) {
      return error.what();
    }
  }
};

TEST_F(SharedFilesTest, what_lies_beneath_a_root_is_opened_where_it_lies) {
  const fs::path wood = write(root / "textures" / "wood.png", "wood");
  const auto file = open(entry(wood, "wood"));
  ASSERT_TRUE(file);
  EXPECT_EQ(text_of(*file), "wood");
  EXPECT_EQ(file->location(), wood);
}

TEST_F(SharedFilesTest, it_stays_the_file_that_was_checked_whatever_takes_its_name) {
  const fs::path wood = write(root / "wood.png", "wood");
  write(folder / "secret" / "key", "keys");
  const auto file = open(entry(wood, "wood"));
  ASSERT_TRUE(file);
  fs::remove(wood);
  fs::create_symlink(folder / "secret" / "key", wood);
  EXPECT_EQ(text_of(*file), "wood");
  file->check_unchanged();
}

TEST_F(SharedFilesTest, nothing_outside_the_roots_is_opened_and_nobody_learns_whether_it_is_there) {
  const fs::path key = write(folder / "secret" / "key", "keys");
  fs::create_directories(folder / "show-of-others");
  write(folder / "show-of-others" / "a", "keys");
  const std::string there = why_not_here(entry(key, "keys"));
  EXPECT_THAT(there, HasSubstr("--asset-root"));
  const std::string nowhere = why_not_here(entry(folder / "secret" / "no-key", "keys"));
  EXPECT_EQ(nowhere.substr(nowhere.find(": ")), there.substr(there.find(": ")));
  EXPECT_THAT(why_not_here(entry(folder / "show-of-others" / "a", "keys")),
              HasSubstr("--asset-root"));
  EXPECT_THAT(why_not_here(entry(root, "keys")), HasSubstr("--asset-root"));
  files = SharedFiles({});
  EXPECT_THAT(why_not_here(entry(root / "textures", "keys")), HasSubstr("--asset-root"));
  EXPECT_EQ(files_read, 0);
}

TEST_F(SharedFilesTest, links_may_lead_about_within_the_roots_and_not_out_of_them) {
  const fs::path wood = write(root / "textures" / "wood.png", "wood");
  fs::create_symlink(wood, root / "absolute.png");
  fs::create_symlink("textures/../textures", root / "folder");
  EXPECT_TRUE(open(entry(root / "absolute.png", "wood")));
  EXPECT_TRUE(open(entry(root / "folder" / "wood.png", "wood")));

  write(folder / "secret" / "key", "keys");
  fs::create_symlink(folder / "secret" / "key", root / "out.png");
  fs::create_symlink("../secret", root / "out");
  for (const char* way : {"out.png", "out/key"})
    EXPECT_THAT(why_not_here(entry(root / way, "keys")), HasSubstr("a link in its path leads out"))
        << way;
  EXPECT_EQ(files_read, 2) << "of those that may be read";
}

TEST_F(SharedFilesTest, a_root_may_itself_be_a_link_and_is_known_by_both_its_names) {
  write(root / "wood.png", "wood");
  fs::create_directory_symlink(root, folder / "mnt");
  files = SharedFiles({folder / "mnt" / ""});
  EXPECT_TRUE(open(entry(folder / "mnt" / "wood.png", "wood")));
  EXPECT_TRUE(open(entry(root / "wood.png", "wood")));
}

TEST_F(SharedFilesTest, what_cannot_be_read_here_may_be_elsewhere) {
  EXPECT_THAT(why_not_here(entry(root / "none.png", "none")),
              HasSubstr("cannot be found on this machine"));
  EXPECT_THAT(why_not_here(entry(root / "textures", "none")), HasSubstr("not a plain file"));
  ASSERT_EQ(mkfifo((root / "pipe").c_str(), 0600), 0);
  EXPECT_THAT(why_not_here(entry(root / "pipe", "none")), HasSubstr("not a plain file"));
  if (geteuid() == 0) return;  // who may read everything
  const fs::path closed = write(root / "closed.png", "none");
  fs::permissions(closed, fs::perms::none);
  EXPECT_THAT(why_not_here(entry(closed, "none")), HasSubstr("may not read it"));
}

TEST_F(SharedFilesTest, other_bytes_than_the_job_says_are_an_error_that_says_so) {
  const fs::path wood = write(root / "wood.png", "wood");
  for (const std::string said : {"woods", "door"}) {
    try {
      (void)open(entry(wood, said));
      ADD_FAILURE() << said;
    } catch (const FileNotHere& error) {
      ADD_FAILURE() << error.what();
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::bad_input);
      EXPECT_THAT(error.what(), HasSubstr("changed since it was submitted"));
    }
  }
}

TEST_F(SharedFilesTest, a_file_is_read_through_once_as_long_as_it_stays_as_it_was) {
  const fs::path wood = write(root / "wood.png", "wood");
  EXPECT_TRUE(open(entry(wood, "wood")));
  EXPECT_TRUE(open(entry(wood, "wood")));
  EXPECT_EQ(files_read, 1);
  const auto before = open(entry(wood, "wood"));
  write(wood, "door");
  fs::last_write_time(wood, fs::file_time_type::clock::now() + std::chrono::seconds(5));
  EXPECT_TRUE(open(entry(wood, "door")));
  EXPECT_EQ(files_read, 2);
  EXPECT_THROW(before->check_unchanged(), Error);
}

TEST_F(SharedFilesTest, odd_locations_and_roots_are_refused) {
  for (const char* odd : {"relative/wood.png", "/show/../secret/key", "/show//key", "/show/./key"})
    EXPECT_THROW((void)open({digest_of("x"), 1, odd}), Error) << odd;
  EXPECT_THROW(SharedFiles({"relative"}), Error);
}

TEST_F(SharedFilesTest, a_stop_ends_the_reading) {
  std::stop_source stop;
  stop.request_stop();
  const fs::path wood = write(root / "wood.png", "wood");
  EXPECT_FALSE(files.open(
      entry(wood, "wood"), [](std::uint64_t) {}, stop.get_token()));
}

}  // namespace
}  // namespace tessera::agent
