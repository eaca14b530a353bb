#include "client/scratch_folder.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <memory>

#include "tests/unit/client/support.hpp"

namespace tessera::client {
namespace {

namespace fs = std::filesystem;

std::size_t entries_of(const fs::path& folder) {
  return static_cast<std::size_t>(
      std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

TEST(ScratchFolder, goes_with_all_that_is_in_it) {
  const TemporaryFolder root;
  {
    const ScratchFolder folder(root.path());
    fs::create_directories(folder.path() / "data" / "jobs");
    EXPECT_EQ(folder.path().parent_path(), root.path());
    EXPECT_EQ(entries_of(root.path()), 1U);
  }
  EXPECT_EQ(entries_of(root.path()), 0U);
}

TEST(ScratchFolder, two_live_beside_each_other) {
  const TemporaryFolder root;
  const ScratchFolder one(root.path());
  const ScratchFolder two(root.path());
  EXPECT_TRUE(fs::exists(one.path()));
  EXPECT_NE(one.path(), two.path());
}

TEST(ScratchFolder, what_a_killed_process_left_is_swept_by_the_next_and_nothing_else) {
  const TemporaryFolder root;
  fs::create_directory(root.path() / "tessera-render-mine");  // without a lock: not one of these
  root.write("tessera-render-note", "a file");
  root.write("other/lock", "");
  const pid_t child = fork();
  if (child == 0) {
    auto* const folder = new ScratchFolder(root.path());
    fs::create_directories(folder->path() / "data");
    raise(SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  ASSERT_EQ(entries_of(root.path()), 4U);
  const ScratchFolder next(root.path());
  EXPECT_EQ(entries_of(root.path()), 4U) << "its own instead of that which was left";
  EXPECT_TRUE(fs::exists(root.path() / "tessera-render-mine"));
  EXPECT_TRUE(fs::exists(root.path() / "other" / "lock"));
}

}  // namespace
}  // namespace tessera::client
