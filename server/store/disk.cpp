#include "server/store/disk.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/file.hpp"
#include "common/base/limits.hpp"

namespace tessera::server {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void fail(const fs::path& path, const char* what, const std::error_code& error) {
  // What stands under a file cannot be made: that is no mere absence.
  const bool under_a_file = error == std::errc::not_a_directory;
  throw Error(under_a_file ? ErrorKind::failed : kind_of(error),
              fmt::format("cannot be {}: {}", what, error.message()), {.file = path.string()});
}

class SystemFile : public DiskFile {
 public:
  explicit SystemFile(File file) : file_(std::move(file)) {}
  [[nodiscard]] const fs::path& path() const override { return file_.path(); }
  [[nodiscard]] std::uint64_t size() const override { return file_.size(); }
  using DiskFile::write_at;
  void write_at(std::vector<iovec>& pieces, std::uint64_t offset) override {
    file_.write_at(pieces, offset);
  }
  void read_at(std::span<std::byte> bytes, std::uint64_t offset) const override {
    file_.read_at(bytes, offset);
  }
  void truncate(std::uint64_t size) override { file_.truncate(size); }
  void sync() override { file_.sync(); }
  void bypass_cache() noexcept override { file_.bypass_cache(); }
  void drop_cached(std::uint64_t from, std::uint64_t to) const noexcept override {
    file_.drop_cached(from, to);
  }

 private:
  File file_;
};

class SystemDisk : public Disk {
 public:
  std::unique_ptr<DiskFile> create(const fs::path& file) override {
    return std::make_unique<SystemFile>(File(file, O_RDWR | O_CREAT | O_EXCL, owner_only));
  }
  std::unique_ptr<DiskFile> edit(const fs::path& file) override {
    return std::make_unique<SystemFile>(File(file, O_RDWR));
  }
  [[nodiscard]] std::unique_ptr<DiskFile> open(const fs::path& file) const override {
    return std::make_unique<SystemFile>(File(file, O_RDONLY));
  }
  [[nodiscard]] std::uint64_t size_of(const fs::path& file) const override {
    std::error_code error;
    const std::uintmax_t bytes = fs::file_size(file, error);
    if (error) fail(file, "looked at", error);
    return bytes;
  }
  std::unique_ptr<DiskFile> hold(const fs::path& file) override {
    File lock(file, O_RDWR | O_CREAT, owner_only);
    if (!lock.try_lock()) return nullptr;
    return std::make_unique<SystemFile>(std::move(lock));
  }
  bool make_folder(const fs::path& folder) override {
    std::error_code error;
    const bool made = fs::create_directory(folder, error);
    if (error) fail(folder, "made", error);
    return made;
  }
  [[nodiscard]] std::vector<std::string> names(const fs::path& folder) const override {
    std::vector<std::string> found;
    std::error_code error;
    for (fs::directory_iterator entry(folder, error); !error && entry != fs::directory_iterator();
         entry.increment(error))
      found.push_back(entry->path().filename().string());
    if (error) fail(folder, "read", error);
    std::sort(found.begin(), found.end());
    return found;
  }
  void remove(const fs::path& file) override {
    std::error_code error;
    if (!fs::remove(file, error) && !error)
      error = std::make_error_code(std::errc::no_such_file_or_directory);
    if (error) fail(file, "removed", error);
  }
  void rename(const fs::path& from, const fs::path& to) override {
    std::error_code error;
    fs::rename(from, to, error);
    if (error) fail(from, "renamed", error);
  }
  void sync_folder(const fs::path& folder) override {
    // Whoever may not read a folder cannot sync it, and has made nothing in it: a data folder's
    // parent can be such a one.
    if (::access(folder.c_str(), R_OK) != 0 && errno == EACCES) return;
    tessera::sync_folder(folder);
  }
};

}  // namespace

void DiskFile::write_at(std::span<const std::byte> bytes, std::uint64_t offset) {
  std::vector<iovec> pieces{{const_cast<std::byte*>(bytes.data()), bytes.size()}};
  write_at(pieces, offset);
}

std::shared_ptr<Disk> system_disk() {
  static const auto disk = std::make_shared<SystemDisk>();
  return disk;
}

void settle(Disk& disk, const fs::path& file) {
  std::unique_ptr<DiskFile> found;
  try {
    found = disk.edit(file);
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::not_found) return;
    throw;
  }
  const std::uint64_t size = found->size();
  std::vector<std::byte> bytes(std::min<std::uint64_t>(size, limits::MiB));
  for (std::uint64_t at = 0; at < size; at += bytes.size()) {
    const auto piece = std::span(bytes).first(
        static_cast<std::size_t>(std::min<std::uint64_t>(bytes.size(), size - at)));
    found->read_at(piece, at);
    found->write_at(piece, at);
  }
  found->sync();
}

void make_folder(Disk& disk, const fs::path& folder, bool durable) {
  try {
    disk.make_folder(folder);
  } catch (const Error& error) {
    throw Error(ErrorKind::failed, error.message(), error.place());
  }
  if (durable) disk.sync_folder(folder.parent_path());
}

std::unique_ptr<DiskFile> open_named(const Disk& disk, const std::filesystem::path& file) {
  try {
    return disk.open(file);
  } catch (const Error& error) {
    throw Error(ErrorKind::failed, error.message(), error.place());
  }
}

std::set<std::uint64_t> numbered_files(const Disk& disk, const std::filesystem::path& folder,
                                       std::string_view extension) {
  std::set<std::uint64_t> found;
  for (const std::string& name : disk.names(folder)) {
    if (!name.ends_with(extension)) continue;
    const std::string stem = name.substr(0, name.size() - extension.size());
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(stem.data(), stem.data() + stem.size(), number);
    if (error == std::errc() && end == stem.data() + stem.size()) found.insert(number);
  }
  return found;
}

void make_folders(Disk& disk, const fs::path& folder, bool durable) {
  fs::path whole = fs::absolute(folder).lexically_normal();
  if (whole.filename().empty()) whole = whole.parent_path();  // it ended with a slash
  std::vector<fs::path> lacking;
  for (fs::path at = whole; at.has_relative_path(); at = at.parent_path()) {
    try {
      disk.make_folder(at);
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::not_found) throw;
      lacking.push_back(at);
      continue;
    }
    if (durable) disk.sync_folder(at.parent_path());
  }
  for (auto at = lacking.rbegin(); at != lacking.rend(); ++at) make_folder(disk, *at, durable);
}

}  // namespace tessera::server
