#include "client/memory_file.hpp"

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

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
  while (descriptor_ >= 0 && !bytes.empty()) {
    const ssize_t written = write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) break;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  if (descriptor_ >= 0 && bytes.empty()) return;
  const int reason = errno;
  if (descriptor_ >= 0) close(descriptor_);
  throw Error(ErrorKind::failed,
              fmt::format("an edited scene cannot be held in memory: {}", std::strerror(reason)));
}

MemoryFile::~MemoryFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

MemoryFile::MemoryFile(MemoryFile&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)) {}

namespace {
constexpr const char* descriptors = "/proc/self/fd";
}  // namespace

std::filesystem::path MemoryFile::path() const {
  return std::filesystem::path(descriptors) / std::to_string(descriptor_);
}

bool MemoryFile::is_one(const std::filesystem::path& path) {
  return path.parent_path() == descriptors;
}

}  // namespace tessera::client
