#include "common/base/files.hpp"

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <span>
#include <string>

#include "common/base/error.hpp"
#include "common/base/file.hpp"

namespace tessera {
namespace {

namespace fs = std::filesystem;

class Files : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::path(testing::TempDir()) / "tessera_files_XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder = name;
  }
  void TearDown() override { fs::remove_all(folder); }

  [[nodiscard]] std::size_t entries() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
  }
  template <class Call>
  static ErrorKind kind_of(Call call, const fs::path& file) {
    try {
      call();
    } catch (const Error& error) {
      EXPECT_EQ(error.place().file, file.string());
      return error.kind();
    }
    ADD_FAILURE() << "nothing was thrown";
    return ErrorKind::failed;
  }

  fs::path folder;
};

TEST_F(Files, WhatBypassesTheCacheIsWrittenWhateverItsAlignment) {
  File file(folder / "bytes", O_RDWR | O_CREAT);
  file.bypass_cache();
  const std::string text = "neither a whole block nor aligned";
  file.write_at(std::as_bytes(std::span(text)).subspan(1), 3);
  std::string read(text.size() - 1, ' ');
  file.read_at(std::as_writable_bytes(std::span(read)), 3);
  EXPECT_EQ(read, text.substr(1));
}

TEST_F(Files, are_read_back_as_they_were_written_and_nothing_else_is_left) {
  const fs::path file = folder / "a.bin";
  std::vector<std::byte> bytes(300'000);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::byte>(i * 7);
  write_file_atomically(file, bytes);
  EXPECT_EQ(read_file(file, bytes.size()), bytes);
  write_file_atomically(file, "short");
  EXPECT_EQ(read_text_file(file, 5), "short");
  write_file_atomically(file, "");
  EXPECT_EQ(read_text_file(file, 0), "");
  EXPECT_EQ(entries(), 1U);
}

TEST_F(Files, that_were_opened_before_they_were_replaced_keep_their_old_content) {
  const fs::path file = folder / "a";
  write_file_atomically(file, "old");
  struct stat before {
  }, after{};
  ASSERT_EQ(::stat(file.c_str(), &before), 0);
  fs::create_hard_link(file, folder / "held");
  write_file_atomically(file, "new");
  ASSERT_EQ(::stat(file.c_str(), &after), 0);
  EXPECT_NE(before.st_ino, after.st_ino);
  EXPECT_EQ(read_text_file(folder / "held", 10), "old");
  EXPECT_EQ(read_text_file(file, 10), "new");
}

TEST_F(Files, cannot_be_written_where_there_is_no_folder_and_the_error_says_so) {
  const fs::path file = folder / "none" / "a";
  EXPECT_EQ(kind_of([&] { write_file_atomically(file, "x"); }, file), ErrorKind::failed);
  EXPECT_EQ(entries(), 0U);
}

TEST_F(Files, that_cannot_be_replaced_leave_nothing_behind) {
  const fs::path file = folder / "taken";
  fs::create_directory(file);
  EXPECT_EQ(kind_of([&] { write_file_atomically(file, "x"); }, file), ErrorKind::failed);
  EXPECT_EQ(entries(), 1U);
  EXPECT_TRUE(fs::is_directory(file));
}

TEST_F(Files, behind_a_link_are_replaced_and_the_link_stays) {
  write_file_atomically(folder / "target", "old");
  fs::create_symlink("target", folder / "link");
  write_file_atomically(folder / "link", "new");
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(read_text_file(folder / "target", 10), "new");
}

TEST_F(Files, that_are_devices_are_written_to_and_not_replaced) {
  write_file_atomically("/dev/null", "gone");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(Files, larger_than_allowed_are_refused) {
  const fs::path file = folder / "a";
  write_file_atomically(file, "12345");
  EXPECT_EQ(kind_of([&] { read_file(file, 4); }, file), ErrorKind::too_large);
  EXPECT_EQ(kind_of([&] { read_file("/dev/zero", 100'000); }, "/dev/zero"), ErrorKind::too_large);
}

TEST_F(Files, without_a_told_size_are_read_to_their_end) {
  EXPECT_THAT(read_text_file("/proc/self/status", 1 << 20), testing::HasSubstr("VmRSS"));
}

TEST_F(Files, that_are_not_there_or_no_files_are_told_by_name) {
  EXPECT_EQ(kind_of([&] { read_file(folder / "none", 4); }, folder / "none"), ErrorKind::not_found);
  EXPECT_EQ(kind_of([&] { read_file(folder, 4); }, folder), ErrorKind::failed);
}

}  // namespace
}  // namespace tessera
