#include "common/assets/file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "common/base/error.hpp"

namespace tessera::assets {

namespace {
[[noreturn]] void fail(const std::filesystem::path& path, std::string_view action) {
  const int number = errno;
  throw Error(number == ENOENT ? ErrorKind::not_found : ErrorKind::failed,
              fmt::format("cannot {}: {}", action, std::generic_category().message(number)),
              {.file = path.string()});
}
}  // namespace

File::File(const std::filesystem::path& path, int flags)
    : path_(path), fd_(::open(path.c_str(), flags | O_CLOEXEC, 0644)) {
  if (fd_ < 0) fail(path_, "open the file");
}

File::~File() {
  if (fd_ >= 0) ::close(fd_);
}

File& File::operator=(File&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(fd_, other.fd_);
  return *this;
}

std::uint64_t File::size() const {
  struct stat found {};
  if (::fstat(fd_, &found) != 0) fail(path_, "read the file's size");
  return static_cast<std::uint64_t>(found.st_size);
}

void File::write_at(std::span<const std::byte> bytes, std::uint64_t offset) {
  while (!bytes.empty()) {
    const ssize_t done = ::pwrite(fd_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (done < 0 && errno == EINTR) continue;
    if (done < 0) fail(path_, "write the file");
    bytes = bytes.subspan(static_cast<std::size_t>(done));
    offset += static_cast<std::uint64_t>(done);
  }
}

void File::truncate(std::uint64_t size) {
  if (::ftruncate(fd_, static_cast<off_t>(size)) != 0) fail(path_, "shorten the file");
}

void File::sync() {
  if (::fsync(fd_) != 0) fail(path_, "sync the file");
}

void File::lock() {
  while (::flock(fd_, LOCK_EX) != 0)
    if (errno != EINTR) fail(path_, "lock the file");
}

bool File::try_lock() {
  if (::flock(fd_, LOCK_EX | LOCK_NB) == 0) return true;
  if (errno != EWOULDBLOCK) fail(path_, "lock the file");
  return false;
}

void sync_folder(const std::filesystem::path& folder) {
  File(folder, O_RDONLY | O_DIRECTORY).sync();
}

}  // namespace tessera::assets
