#include "client/memory_file.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <vector>

#include "common/base/files.hpp"

namespace tessera::client {
namespace {

TEST(MemoryFile, is_read_by_its_path) {
  const MemoryFile file("a scene");
  EXPECT_EQ(read_text_file(file.path(), 100), "a scene");
}

TEST(MemoryFile, there_can_be_more_than_the_soft_limit_of_open_files) {
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &before), 0);
  rlimit low = before;
  low.rlim_cur = 48;
  ASSERT_GT(before.rlim_max, 200U);
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &low), 0);
  std::vector<MemoryFile> files;
  EXPECT_NO_THROW({
    for (int k = 0; k < 100; ++k) files.emplace_back("x");
  });
  EXPECT_EQ(files.size(), 100U);
  files.clear();
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &before), 0);
}

}  // namespace
}  // namespace tessera::client
