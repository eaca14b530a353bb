#include "common/base/file.hpp"

#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <system_error>

#include "common/base/error.hpp"

namespace tessera {

namespace {

[[noreturn]] void throw_for(const std::filesystem::path& path, const char* what, int code) {
  const std::error_code error(code, std::generic_category());
  throw Error(kind_of(error), fmt::format("cannot be {}: {}", what, error.message()),
              {.file = path.string()});
}

}  // namespace

File::File(std::filesystem::path path, int flags, mode_t mode)
    : descriptor_(::open(path.c_str(), flags | O_CLOEXEC, mode)), path_(std::move(path)) {
  if (!is_open()) fail("opened");
}

void File::fail(const char* what) const { throw_for(path_, what, errno); }

std::uint64_t File::size() const {
  struct stat status {};
  if (::fstat(descriptor_.number(), &status) != 0) fail("looked at");
  return static_cast<std::uint64_t>(status.st_size);
}

void File::write_all(std::vector<iovec>& pieces, bool at_offset, std::uint64_t offset) {
  std::erase_if(pieces, [](const iovec& piece) { return piece.iov_len == 0; });
  std::size_t at = 0;
  while (at < pieces.size()) {
    const int count = static_cast<int>(std::min<std::size_t>(pieces.size() - at, IOV_MAX));
    const ssize_t wrote =
        at_offset ? ::pwritev(descriptor_.number(), &pieces[at], count, static_cast<off_t>(offset))
                  : ::writev(descriptor_.number(), &pieces[at], count);
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote < 0 && errno == EINVAL && use_cache()) continue;
    if (wrote < 0) fail("written");
    if (wrote == 0) throw_for(path_, "written", ENOSPC);
    offset += static_cast<std::uint64_t>(wrote);
    auto left = static_cast<std::size_t>(wrote);
    while (at < pieces.size() && left >= pieces[at].iov_len) left -= pieces[at++].iov_len;
    if (left > 0) {
      pieces[at].iov_base = static_cast<std::byte*>(pieces[at].iov_base) + left;
      pieces[at].iov_len -= left;
    }
  }
}

void File::write_at(std::vector<iovec>& pieces, std::uint64_t offset) {
  write_all(pieces, true, offset);
}

void File::write_at(std::span<const std::byte> bytes, std::uint64_t offset) {
  std::vector<iovec> pieces{{const_cast<std::byte*>(bytes.data()), bytes.size()}};
  write_all(pieces, true, offset);
}

void File::write(std::span<const std::byte> bytes) {
  std::vector<iovec> pieces{{const_cast<std::byte*>(bytes.data()), bytes.size()}};
  write_all(pieces, false, 0);
}

void File::read_at(std::span<std::byte> bytes, std::uint64_t offset) const {
  while (!bytes.empty()) {
    const ssize_t got =
        ::pread(descriptor_.number(), bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail("read");
    if (got == 0)
      throw Error(ErrorKind::failed, "ends before what is to be read", {.file = path_.string()});
    bytes = bytes.subspan(static_cast<std::size_t>(got));
    offset += static_cast<std::uint64_t>(got);
  }
}

std::size_t File::read_some(std::span<std::byte> bytes) const {
  for (;;) {
    const ssize_t got = ::read(descriptor_.number(), bytes.data(), bytes.size());
    if (got >= 0) return static_cast<std::size_t>(got);
    if (errno != EINTR) fail("read");
  }
}

void File::truncate(std::uint64_t size) {
  if (::ftruncate(descriptor_.number(), static_cast<off_t>(size)) != 0) fail("truncated");
}

void File::sync() {
  if (::fdatasync(descriptor_.number()) != 0) fail("synced");
}

void File::bypass_cache() noexcept {
  const int flags = ::fcntl(descriptor_.number(), F_GETFL);
  if (flags >= 0) static_cast<void>(::fcntl(descriptor_.number(), F_SETFL, flags | O_DIRECT));
}

/// False if it was used already.
bool File::use_cache() noexcept {
  const int flags = ::fcntl(descriptor_.number(), F_GETFL);
  return flags >= 0 && (flags & O_DIRECT) != 0 &&
         ::fcntl(descriptor_.number(), F_SETFL, flags & ~O_DIRECT) == 0;
}

void File::drop_cached(std::uint64_t from, std::uint64_t to) const noexcept {
  if (to <= from) return;
  static_cast<void>(::posix_fadvise(descriptor_.number(), static_cast<off_t>(from),
                                    static_cast<off_t>(to - from), POSIX_FADV_DONTNEED));
}

void File::lock() {
  while (::flock(descriptor_.number(), LOCK_EX) != 0)
    if (errno != EINTR) fail("locked");
}

bool File::try_lock() {
  if (::flock(descriptor_.number(), LOCK_EX | LOCK_NB) == 0) return true;
  if (errno != EWOULDBLOCK) fail("locked");
  return false;
}

void sync_folder(const std::filesystem::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) throw_for(folder, "opened", errno);
  // Some file systems cannot sync a folder, and say EINVAL; a rename is then as safe as they make
  // it. In one that cannot be written nothing has changed.
  const int problem = ::fsync(descriptor) != 0 && errno != EINVAL && errno != EROFS ? errno : 0;
  ::close(descriptor);
  if (problem != 0) throw_for(folder, "synced", problem);
}

}  // namespace tessera
