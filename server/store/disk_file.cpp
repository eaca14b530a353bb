#include "server/store/disk_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <system_error>

#include "common/base/error.hpp"

namespace tessera::server {

DiskFile::DiskFile(std::filesystem::path path, int flags) : path_(std::move(path)) {
  constexpr mode_t owner_only = 0600;
  descriptor_ = ::open(path_.c_str(), flags | O_CLOEXEC, owner_only);
  if (descriptor_ < 0) fail("opened", errno);
}

DiskFile::~DiskFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void DiskFile::fail(const char* what, int error) const {
  throw Error(ErrorKind::failed, fmt::format("{} could not be {}: {}", path_.string(), what,
                                             std::generic_category().message(error)));
}

std::uint64_t DiskFile::size() const {
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0) fail("looked at", errno);
  return static_cast<std::uint64_t>(status.st_size);
}

void DiskFile::write(std::vector<iovec>& pieces, std::uint64_t offset) {
  std::size_t at = 0;
  while (at < pieces.size()) {
    const int count = static_cast<int>(std::min<std::size_t>(pieces.size() - at, IOV_MAX));
    const ssize_t wrote = ::pwritev(descriptor_, &pieces[at], count, static_cast<off_t>(offset));
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote <= 0) fail("written", wrote < 0 ? errno : ENOSPC);
    offset += static_cast<std::uint64_t>(wrote);
    auto left = static_cast<std::size_t>(wrote);
    while (at < pieces.size() && left >= pieces[at].iov_len) left -= pieces[at++].iov_len;
    if (left > 0) {
      pieces[at].iov_base = static_cast<std::byte*>(pieces[at].iov_base) + left;
      pieces[at].iov_len -= left;
    }
  }
}

void DiskFile::write(std::span<const std::byte> bytes, std::uint64_t offset) {
  std::vector<iovec> pieces{{const_cast<std::byte*>(bytes.data()), bytes.size()}};
  write(pieces, offset);
}

void DiskFile::read(std::span<std::byte> bytes, std::uint64_t offset) const {
  while (!bytes.empty()) {
    const ssize_t got =
        ::pread(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail("read", errno);
    if (got == 0) throw Error(ErrorKind::failed, fmt::format("{} ends too early", path_.string()));
    bytes = bytes.subspan(static_cast<std::size_t>(got));
    offset += static_cast<std::uint64_t>(got);
  }
}

void DiskFile::truncate(std::uint64_t size) {
  if (::ftruncate(descriptor_, static_cast<off_t>(size)) != 0) fail("truncated", errno);
}

void DiskFile::sync() {
  if (::fdatasync(descriptor_) != 0) fail("synced", errno);
}

void DiskFile::drop_cached(std::uint64_t from, std::uint64_t to) const noexcept {
  if (to <= from) return;
  static_cast<void>(::posix_fadvise(descriptor_, static_cast<off_t>(from),
                                    static_cast<off_t>(to - from), POSIX_FADV_DONTNEED));
}

void sync_folder(const std::filesystem::path& folder) {
  DiskFile file(folder, O_RDONLY | O_DIRECTORY);
  file.sync();
}

}  // namespace tessera::server
