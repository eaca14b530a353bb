#pragma once
#include <fcntl.h>
#include <sys/uio.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "common/base/descriptor.hpp"

/// Files by descriptor. Every call throws Error with the file's name and the system's word for what
/// went wrong: not_found where there is no such name, else failed.
namespace tessera {

constexpr mode_t owner_only = 0600;

/// An open file; closed when it goes. Calls that only read may be made by any thread.
class File {
 public:
  File() = default;
  /// `flags` as open(2) takes them, close-on-exec always; `mode` of a new file, less the umask.
  File(std::filesystem::path path, int flags, mode_t mode = 0644);

  [[nodiscard]] bool is_open() const { return descriptor_.is_open(); }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::uint64_t size() const;

  /// All of them one after another from `offset` on; changes `pieces`.
  void write_at(std::vector<iovec>& pieces, std::uint64_t offset);
  void write_at(std::span<const std::byte> bytes, std::uint64_t offset);
  /// All of them where the file stands, for what has no offsets: a pipe, a device.
  void write(std::span<const std::byte> bytes);
  /// Reads all of `bytes`; a file that ends before that is an error.
  void read_at(std::span<std::byte> bytes, std::uint64_t offset) const;
  /// What is there to be read where the file stands: how many bytes; 0 at its end.
  std::size_t read_some(std::span<std::byte> bytes) const;
  void truncate(std::uint64_t size);
  /// The bytes and the file's length are on the disk (fdatasync).
  void sync();
  /// From here on writes go past the system's page cache (O_DIRECT), as long as the file system
  /// takes them so; else through it, as before. Memory, offsets and lengths of what is written
  /// should be multiples of the disk's block. Other descriptors read what was written.
  void bypass_cache() noexcept;
  /// The system need not keep these bytes, which are synced, in memory any more. Only advice: it
  /// never fails.
  void drop_cached(std::uint64_t from, std::uint64_t to) const noexcept;

  /// Waits for the file's lock (flock), which this descriptor then holds until it is closed, also
  /// against the same process; the system lets it go when the process dies.
  void lock();
  /// False if another descriptor holds it.
  bool try_lock();

 private:
  [[noreturn]] void fail(const char* what) const;
  bool use_cache() noexcept;
  void write_all(std::vector<iovec>& pieces, bool at_offset, std::uint64_t offset);

  Descriptor descriptor_;
  std::filesystem::path path_;
};

/// Makes names that were made or removed in the folder survive a power cut, as far as its file
/// system can.
void sync_folder(const std::filesystem::path& folder);

}  // namespace tessera
