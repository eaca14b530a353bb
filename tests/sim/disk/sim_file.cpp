// The simulated disk as the store's own code sees it.
#include <algorithm>
#include <cstring>

#include "common/base/error.hpp"
#include "tests/sim/disk/sim_disk.hpp"

namespace tessera::sim {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void absent(const fs::path& path) {
  throw Error(ErrorKind::not_found, "is not there", {.file = path.string()});
}

void require_power(const SimDisk& disk, const fs::path& path) {
  if (disk.dead())
    throw Error(ErrorKind::failed, "cannot be read: the process has ended",
                {.file = path.string()});
}

class SimFile : public server::DiskFile {
 public:
  SimFile(SimDisk& disk, SimDisk::InodePtr inode, fs::path path)
      : disk_(disk), inode_(std::move(inode)), path_(std::move(path)) {}

  [[nodiscard]] const fs::path& path() const override { return path_; }
  [[nodiscard]] std::uint64_t size() const override {
    require_power(disk_, path_);
    return inode_->bytes().size();
  }
  using server::DiskFile::write_at;
  void write_at(std::vector<iovec>& pieces, std::uint64_t offset) override {
    for (const iovec& piece : pieces) {
      const std::span bytes(static_cast<const std::byte*>(piece.iov_base), piece.iov_len);
      require_done(disk_.write(*inode_, path_.string(), offset, bytes), path_.string(), "written");
      offset += piece.iov_len;
    }
  }
  void read_at(std::span<std::byte> bytes, std::uint64_t offset) const override {
    require_power(disk_, path_);
    const auto& all = inode_->bytes();
    if (offset > all.size() || bytes.size() > all.size() - offset)
      throw Error(ErrorKind::failed, "ends before what is to be read", {.file = path_.string()});
    if (!bytes.empty()) std::memcpy(bytes.data(), all.data() + offset, bytes.size());
  }
  void truncate(std::uint64_t size) override {
    require_done(disk_.truncate(*inode_, path_.string(), size), path_.string(), "truncated");
  }
  void sync() override {
    require_done(disk_.sync(*inode_, path_.string()), path_.string(), "synced");
  }
  void drop_cached(std::uint64_t, std::uint64_t) const noexcept override {}

 private:
  SimDisk& disk_;
  SimDisk::InodePtr inode_;
  fs::path path_;
};

}  // namespace

class HeldFile : public SimFile {
 public:
  HeldFile(SimDisk& disk, const SimDisk::InodePtr& inode, const fs::path& path)
      : SimFile(disk, inode, path), held_(disk.held_), name_(path.string()) {
    held_.insert(name_);
  }
  ~HeldFile() override { held_.erase(name_); }

 private:
  std::set<std::string>& held_;
  std::string name_;
};

std::unique_ptr<server::DiskFile> SimDisk::create(const fs::path& file) {
  if (find(file.string()))
    throw Error(ErrorKind::failed, "cannot be opened: File exists", {.file = file.string()});
  if (!find(file.parent_path().string())) absent(file);
  Done done = Done::yes;
  const InodePtr inode = make(file.string(), done);
  require_done(done, file.string(), "opened");
  return std::make_unique<SimFile>(*this, inode, file);
}

std::unique_ptr<server::DiskFile> SimDisk::edit(const fs::path& file) {
  require_power(*this, file);
  const InodePtr inode = find(file.string());
  if (!inode) absent(file);
  return std::make_unique<SimFile>(*this, inode, file);
}

std::unique_ptr<server::DiskFile> SimDisk::open(const fs::path& file) const {
  return const_cast<SimDisk&>(*this).edit(file);
}

std::unique_ptr<server::DiskFile> SimDisk::hold(const fs::path& file) {
  require_power(*this, file);
  if (held_.contains(file.string())) return nullptr;
  InodePtr inode = find(file.string());
  if (!inode) {
    Done done = Done::yes;
    inode = make(file.string(), done);
    require_done(done, file.string(), "opened");
  }
  return std::make_unique<HeldFile>(*this, inode, file);
}

bool SimDisk::make_folder(const fs::path& folder) {
  require_power(*this, folder);
  if (find(folder.string())) return false;
  if (!find(folder.parent_path().string())) absent(folder);
  const NameChange made{"", folder.string(), std::make_shared<Inode>()};
  require_done(change(Point::make_folder, folder.string(), made), folder.string(), "made");
  return true;
}

std::vector<std::string> SimDisk::names(const fs::path& folder) const {
  require_power(*this, folder);
  if (!find(folder.string())) absent(folder);
  std::vector<std::string> found;
  for (const auto& [name, inode] : names_) {
    const fs::path path(name);
    if (path.parent_path() == folder && path != folder) found.push_back(path.filename().string());
  }
  return found;
}

void SimDisk::remove(const fs::path& file) {
  require_power(*this, file);
  if (!find(file.string())) absent(file);
  require_done(unlink(file.string()), file.string(), "removed");
}

void SimDisk::rename(const fs::path& from, const fs::path& to) {
  require_power(*this, from);
  const InodePtr inode = find(from.string());
  if (!inode) absent(from);
  require_done(change(Point::rename, to.string(), {from.string(), to.string(), inode}),
               from.string(), "renamed");
}

void SimDisk::sync_folder(const fs::path& folder) {
  require_power(*this, folder);
  if (!find(folder.string())) absent(folder);
  require_done(settle(folder.string()), folder.string(), "synced");
}

}  // namespace tessera::sim
