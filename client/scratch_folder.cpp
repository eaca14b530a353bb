#include "client/scratch_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <string>
#include <string_view>

#include "common/base/error.hpp"
#include "common/base/random.hpp"

namespace tessera::client {

namespace fs = std::filesystem;

namespace {

/// A folder gets its name once its lock is held, so that it is never found without.
constexpr std::string_view prefix = "tessera-render-";
constexpr std::string_view unfinished = ".tessera-render-";
constexpr const char* lock_name = "lock";

/// The lock's descriptor, or -1 if somebody holds it or there is none.
int try_lock(const fs::path& folder, int flags) {
  const int lock =
      open((folder / lock_name).c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | flags, 0600);
  if (lock < 0) return -1;
  if (flock(lock, LOCK_EX | LOCK_NB) == 0) return lock;
  close(lock);
  return -1;
}

bool is_own_folder(const fs::path& path) {
  struct stat found {};
  return lstat(path.c_str(), &found) == 0 && S_ISDIR(found.st_mode) && found.st_uid == geteuid();
}

void sweep(const fs::path& root) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(root, error)) {
    if (!entry.path().filename().string().starts_with(prefix) || !is_own_folder(entry.path()))
      continue;
    const int lock = try_lock(entry.path(), 0);
    if (lock < 0) continue;  // somebody lives in it, or it is not one of these
    fs::remove_all(entry.path(), error);
    close(lock);
  }
}

}  // namespace

ScratchFolder::ScratchFolder(const fs::path& given) {
  std::error_code error;
  fs::path root = given.empty() ? fs::temp_directory_path(error) : given;
  if (error) root = "/tmp";
  sweep(root);
  std::string made = (root / fmt::format("{}XXXXXX", unfinished)).string();
  if (mkdtemp(made.data()) == nullptr)
    throw Error(ErrorKind::failed,
                fmt::format("no temporary folder can be made in {}", root.string()));
  lock_ = try_lock(made, O_CREAT);
  path_ = root / fmt::format("{}{}", prefix, random_hex(8));
  if (lock_ >= 0) fs::rename(made, path_, error);
  if (lock_ >= 0 && !error) return;
  fs::remove_all(made, error);
  if (lock_ >= 0) close(lock_);
  throw Error(ErrorKind::failed,
              fmt::format("no temporary folder can be locked in {}", root.string()));
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  close(lock_);
}

}  // namespace tessera::client
