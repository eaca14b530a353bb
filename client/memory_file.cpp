#include "client/memory_file.hpp"

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "common/base/error.hpp"

namespace tessera::client {

namespace {

/// A wedge may have more scenes than the usual soft limit has files: then up to the hard one.
int create() {
  const int descriptor = memfd_create("tessera", MFD_CLOEXEC);
  rlimit limit{};
  if (descriptor >= 0 || errno != EMFILE || getrlimit(RLIMIT_NOFILE, &limit) != 0)
    return descriptor;
  limit.rlim_cur = limit.rlim_max;
  return setrlimit(RLIMIT_NOFILE, &limit) == 0 ? memfd_create("tessera", MFD_CLOEXEC) : -1;
}

}  // namespace

MemoryFile::MemoryFile(std::string_view bytes) : descriptor_(create()) {
  while (descriptor_.is_open() && !bytes.empty()) {
    const ssize_t written = write(descriptor_.number(), bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) break;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  if (!descriptor_.is_open() || !bytes.empty())
    throw Error(ErrorKind::failed,
                fmt::format("an edited scene cannot be held in memory: {}", std::strerror(errno)));
}

bool MemoryFile::is_one(const std::filesystem::path& path) {
  return path.parent_path() == Descriptor::folder;
}

}  // namespace tessera::client
