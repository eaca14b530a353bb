#pragma once
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "server/store/disk.hpp"
#include "tests/sim/disk/faults.hpp"
#include "tests/sim/disk/inode.hpp"

struct sqlite3_vfs;

namespace tessera::sim {

/// A disk in memory for the real store, its SQLite included. Each change is a numbered fault point.
/// Once the process is killed or the power is cut nothing works any more, until power_on().
class SimDisk : public server::Disk {
 public:
  explicit SimDisk(std::uint64_t seed);
  ~SimDisk() override;
  SimDisk(const SimDisk&) = delete;
  SimDisk& operator=(const SimDisk&) = delete;

  // ---- the store's side ----
  std::unique_ptr<server::DiskFile> create(const std::filesystem::path& file) override;
  std::unique_ptr<server::DiskFile> edit(const std::filesystem::path& file) override;
  [[nodiscard]] std::unique_ptr<server::DiskFile> open(
      const std::filesystem::path& file) const override;
  std::unique_ptr<server::DiskFile> hold(const std::filesystem::path& file) override;
  bool make_folder(const std::filesystem::path& folder) override;
  [[nodiscard]] std::vector<std::string> names(const std::filesystem::path& folder) const override;
  void remove(const std::filesystem::path& file) override;
  void rename(const std::filesystem::path& from, const std::filesystem::path& to) override;
  void sync_folder(const std::filesystem::path& folder) override;
  [[nodiscard]] const char* sqlite_vfs() const override { return vfs_name_.c_str(); }

  // ---- the simulation's side ----
  Faults faults;
  /// Between two points: the process ends; what it wrote is all there.
  void kill();
  /// Between two points: what was not synced is lost, or torn, or not.
  void cut_power();
  /// A fault point where nothing is done: a call of the store has come back. False if that was the
  /// end of the process.
  bool commit_point();
  [[nodiscard]] bool dead() const { return dead_; }
  /// The next process may begin. Every file of the last one must be closed.
  void power_on();
  [[nodiscard]] std::uint64_t sectors_lost() const { return sectors_lost_; }
  /// Bytes of all files in the folder whose names end so, as programs see them.
  [[nodiscard]] std::uint64_t bytes_in(const std::filesystem::path& folder,
                                       std::string_view suffix) const;
  /// Each point as it is reached, for a trace.
  std::function<void(std::uint64_t number, Point, Fault, const std::string& file)> watch;

  // ---- files by their inode: for DiskFile and the VFS ----
  using InodePtr = std::shared_ptr<Inode>;
  /// What a change has come to.
  enum class Done { yes, failed, full };
  [[nodiscard]] InodePtr find(const std::string& file) const;
  InodePtr make(const std::string& file, Done& done);
  Done write(Inode& inode, const std::string& file, std::uint64_t offset,
             std::span<const std::byte> bytes);
  Done truncate(Inode& inode, const std::string& file, std::uint64_t size);
  Done sync(Inode& inode, const std::string& file);
  Done unlink(const std::string& file);
  Done settle(const std::string& folder);

 private:
  /// A change of names: `made` gets the name `to`; `from` is no name any more. Either may be empty.
  struct NameChange {
    std::string from, to;
    InodePtr made;
  };
  using Names = std::map<std::string, InodePtr>;  // whole paths; folders have an inode, too

  Fault reach(Point point, const std::string& file);
  /// Changes names now; they are certain once the folder is synced.
  Done change(Point point, const std::string& file, NameChange change);
  static void apply(Names& names, const NameChange& change);
  void lose_names(const CutWeather& weather);
  void die(bool power);

  Random random_;
  std::string vfs_name_;
  std::shared_ptr<sqlite3_vfs> vfs_;
  Names names_, safe_;
  std::map<std::string, std::vector<NameChange>> unsynced_;  // by folder
  std::set<std::string> held_;
  bool dead_ = false;
  bool power_lost_ = false;
  std::uint64_t sectors_lost_ = 0;
  friend class HeldFile;
};

/// What a change has come to, as an Error for the store.
void require_done(SimDisk::Done done, const std::string& file, const char* what);

}  // namespace tessera::sim
