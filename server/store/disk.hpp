#pragma once
#include <sys/uio.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// The files that the store works on, and nothing more of them than it needs: the system's, or a
/// simulation's that fails where it is told to. Every call throws Error with the file's name and
/// what went wrong: not_found where there is no such name, else failed.
namespace tessera::server {

/// An open file. Calls that only read may be made by any thread.
class DiskFile {
 public:
  virtual ~DiskFile() = default;
  [[nodiscard]] virtual const std::filesystem::path& path() const = 0;
  [[nodiscard]] virtual std::uint64_t size() const = 0;
  /// All of them one after another from `offset` on; changes `pieces`. If it throws, any part of
  /// them may stand there.
  virtual void write_at(std::vector<iovec>& pieces, std::uint64_t offset) = 0;
  void write_at(std::span<const std::byte> bytes, std::uint64_t offset);
  /// Reads all of `bytes`; a file that ends before that is an error.
  virtual void read_at(std::span<std::byte> bytes, std::uint64_t offset) const = 0;
  virtual void truncate(std::uint64_t size) = 0;
  /// The bytes and the file's length survive a power cut; its name need not (sync_folder). If it
  /// throws, any part of what was written may be lost, also when a later sync succeeds.
  virtual void sync() = 0;
  /// What is written from here on is seldom read: it need not pass through the system's page cache
  /// (File::bypass_cache). Only advice.
  virtual void bypass_cache() noexcept {}
  /// The system need not keep these bytes, which are synced, in memory. Only advice.
  virtual void drop_cached(std::uint64_t from, std::uint64_t to) const noexcept = 0;
};

class Disk {
 public:
  virtual ~Disk() = default;
  /// An empty file, open to read and write; an error if the name is taken.
  virtual std::unique_ptr<DiskFile> create(const std::filesystem::path& file) = 0;
  /// One that is there, to read and write.
  virtual std::unique_ptr<DiskFile> edit(const std::filesystem::path& file) = 0;
  /// To read alone.
  [[nodiscard]] virtual std::unique_ptr<DiskFile> open(const std::filesystem::path& file) const = 0;
  /// Its bytes, without opening it if that can be.
  [[nodiscard]] virtual std::uint64_t size_of(const std::filesystem::path& file) const {
    return open(file)->size();
  }
  /// The file, made if it is not there, held until it is closed or the process dies; nullptr if
  /// somebody else holds it.
  virtual std::unique_ptr<DiskFile> hold(const std::filesystem::path& file) = 0;
  /// False if there is one already. Its parent must be there.
  virtual bool make_folder(const std::filesystem::path& folder) = 0;
  /// Names of the files and folders in it, ascending.
  [[nodiscard]] virtual std::vector<std::string> names(
      const std::filesystem::path& folder) const = 0;
  virtual void remove(const std::filesystem::path& file) = 0;
  /// Atomic: `to` is what it was, or what `from` was. Within one folder.
  virtual void rename(const std::filesystem::path& from, const std::filesystem::path& to) = 0;
  /// Names that were made, renamed or removed in the folder are so after a power cut, too.
  virtual void sync_folder(const std::filesystem::path& folder) = 0;
  /// The VFS by which SQLite reaches the same disk; nullptr: its own.
  [[nodiscard]] virtual const char* sqlite_vfs() const { return nullptr; }
};

/// The machine's.
std::shared_ptr<Disk> system_disk();

/// To read alone what is named in the database: that it is not there is a failure, and no mistake
/// of who asks.
std::unique_ptr<DiskFile> open_named(const Disk& disk, const std::filesystem::path& file);

/// The numbers of the files NUMBER + `extension` in the folder.
std::set<std::uint64_t> numbered_files(const Disk& disk, const std::filesystem::path& folder,
                                       std::string_view extension);

/// Makes what can be read of the file certain, if it is there: also where a sync of it had failed,
/// after which the system still shows what it has not written, and no other sync would write it.
void settle(Disk& disk, const std::filesystem::path& file);

/// Makes the folder, whose parent is there. If `durable` its name survives a power cut, also where
/// an earlier call had made it and was interrupted.
void make_folder(Disk& disk, const std::filesystem::path& folder, bool durable);

/// The same with whatever of its parents is lacking; what was said of its name goes for all of
/// theirs.
void make_folders(Disk& disk, const std::filesystem::path& folder, bool durable);

}  // namespace tessera::server
