#include "worker/agent/shared_files.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include "common/base/file.hpp"
#include "common/base/limits.hpp"

namespace tessera::agent {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t checked_most = limits::bundle_files;

[[noreturn]] void not_here(const fs::path& location, const std::string& why) {
  throw FileNotHere(ErrorKind::not_found, why, {.file = location.string()});
}

[[noreturn]] void other_bytes(const fs::path& location, const std::string& what) {
  throw Error(ErrorKind::bad_input, fmt::format("{}: it was changed since it was submitted", what),
              {.file = location.string()});
}

bool is_beneath(const fs::path& file, const fs::path& root) {
  const auto [in_root, in_file] = std::mismatch(root.begin(), root.end(), file.begin(), file.end());
  return in_root == root.end() && in_file != file.end();
}

/// Opens a path that has no links in it, without following any: one that was put there meanwhile is
/// refused. Nothing is read, and no device awakes (O_PATH).
Descriptor open_without_links(const fs::path& path) {
  Descriptor at(::open("/", O_PATH | O_DIRECTORY | O_CLOEXEC));
  for (const fs::path& part : path.relative_path()) {
    Descriptor next(::openat(at.number(), part.c_str(), O_PATH | O_NOFOLLOW | O_CLOEXEC));
    if (!next.is_open()) return next;
    at = std::move(next);
  }
  return at;
}

std::int64_t nanoseconds(const timespec& time) {
  constexpr std::int64_t second = 1'000'000'000;
  return std::int64_t{time.tv_sec} * second + time.tv_nsec;
}

File reader_of(const SharedFile& file) {
  try {
    return {file.path(), O_RDONLY};
  } catch (const Error& error) {
    not_here(file.location(), "this worker may not read it: " + error.message());
  }
}

/// Nothing if `stop` was asked for.
std::optional<Digest> digest_of(const File& file,
                                const std::function<void(std::uint64_t)>& on_bytes,
                                const std::stop_token& stop) {
  std::vector<std::byte> piece(limits::MiB);
  Sha256 sha;
  std::uint64_t read = 0;
  while (const std::size_t got = file.read_some(piece)) {
    if (stop.stop_requested()) return std::nullopt;
    sha.update(std::span<const std::byte>(piece).first(got));
    on_bytes(read += got);
  }
  return sha.finish();
}

}  // namespace

SharedFile::SharedFile(Descriptor descriptor, fs::path location)
    : descriptor_(std::move(descriptor)), location_(std::move(location)), opened_(stamp()) {}

FileStamp SharedFile::stamp() const {
  struct stat status {};
  if (::fstat(descriptor_.number(), &status) != 0)
    throw Error(ErrorKind::failed, "cannot be looked at: " + std::generic_category().message(errno),
                {.file = location_.string()});
  return {.device = status.st_dev,
          .inode = status.st_ino,
          .size = static_cast<std::uint64_t>(status.st_size),
          .modified = nanoseconds(status.st_mtim),
          .changed = nanoseconds(status.st_ctim)};
}

void SharedFile::check_unchanged() const {
  const FileStamp now = stamp();
  if (now.size != opened_.size || now.modified != opened_.modified)
    other_bytes(location_, "it has been written to");
}

SharedFiles::SharedFiles(std::vector<fs::path> roots) : roots_(std::move(roots)) {
  for (fs::path& root : roots_) {
    if (!root.is_absolute())
      throw Error(
          ErrorKind::bad_input,
          fmt::format("--asset-root: expected an absolute path, found \"{}\"", root.string()));
    root = root.lexically_normal();
    if (!root.has_filename()) root = root.parent_path();  // "/mnt/show/"
  }
}

SharedFile SharedFiles::open_beneath(const fs::path& location) const {
  std::vector<fs::path> real_roots;
  for (const fs::path& root : roots_) {
    std::error_code missing;
    const fs::path real = fs::canonical(root, missing);
    if (!missing) real_roots.push_back(real);
  }
  const auto is_allowed = [&](const fs::path& file) {
    const auto has_it = [&](const fs::path& root) { return is_beneath(file, root); };
    return std::any_of(roots_.begin(), roots_.end(), has_it) ||
           std::any_of(real_roots.begin(), real_roots.end(), has_it);
  };
  // Asked before anything is looked at: of what lies elsewhere nobody learns whether it is there.
  if (!is_allowed(location))
    not_here(location,
             "it lies beneath no folder that this worker may read jobs' files from "
             "(tessera-worker --asset-root)");
  std::error_code error;
  const fs::path real = fs::canonical(location, error);
  if (error) not_here(location, "cannot be found on this machine: " + error.message());
  if (std::none_of(real_roots.begin(), real_roots.end(),
                   [&](const fs::path& root) { return is_beneath(real, root); }))
    not_here(location,
             "a link in its path leads out of the folders that this worker may read "
             "(tessera-worker --asset-root)");
  Descriptor found(open_without_links(real));
  struct stat status {};
  if (!found.is_open() || ::fstat(found.number(), &status) != 0)
    not_here(location, "cannot be opened: " + std::generic_category().message(errno));
  if (!S_ISREG(status.st_mode)) not_here(location, "is not a plain file");
  return {std::move(found), location};
}

std::optional<SharedFile> SharedFiles::open(const assets::BundleFile& entry,
                                            const std::function<void(std::uint64_t)>& on_bytes,
                                            const std::stop_token& stop) {
  assets::check_location(entry.location);
  SharedFile file = open_beneath(entry.location);
  const FileStamp before = file.stamp();
  if (before.size != entry.size)
    other_bytes(entry.location,
                fmt::format("it has {} bytes, and the job says {}", before.size, entry.size));
  const auto known = checked_.find(entry.location);
  if (known != checked_.end() && known->second == Checked{before, entry.digest}) return file;
  const auto digest = digest_of(reader_of(file), on_bytes, stop);
  if (!digest) return std::nullopt;
  file.check_unchanged();
  if (*digest != entry.digest)
    other_bytes(entry.location, fmt::format("its SHA-256 is {}, and the job says {}", digest->hex(),
                                            entry.digest.hex()));
  if (checked_.size() >= checked_most) checked_.clear();
  checked_.insert_or_assign(entry.location, Checked{before, *digest});
  return file;
}

}  // namespace tessera::agent
