#pragma once
#include <sys/uio.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <utility>
#include <vector>

namespace tessera::server {

/// An open file. Every call throws Error{failed} with the file's name and the system's word for
/// what went wrong.
class DiskFile {
 public:
  DiskFile() = default;
  /// `flags` as open(2) takes them; new files are readable by their owner alone.
  DiskFile(std::filesystem::path path, int flags);
  ~DiskFile();
  DiskFile(DiskFile&& other) noexcept { swap(other); }
  DiskFile& operator=(DiskFile&& other) noexcept {
    swap(other);
    return *this;
  }

  [[nodiscard]] bool is_open() const { return descriptor_ >= 0; }
  [[nodiscard]] int descriptor() const { return descriptor_; }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::uint64_t size() const;
  /// Writes all pieces one after another from `offset` on; changes `pieces`.
  void write(std::vector<iovec>& pieces, std::uint64_t offset);
  void write(std::span<const std::byte> bytes, std::uint64_t offset);
  /// Reads all of `bytes`; a file that ends before that is an error.
  void read(std::span<std::byte> bytes, std::uint64_t offset) const;
  void truncate(std::uint64_t size);
  /// fdatasync: the bytes and the file's length.
  void sync();
  /// The system need not keep these bytes, which are synced, in memory any more. Only advice: it
  /// never fails.
  void drop_cached(std::uint64_t from, std::uint64_t to) const noexcept;

 private:
  void swap(DiskFile& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    std::swap(path_, other.path_);
  }
  [[noreturn]] void fail(const char* what, int error) const;

  int descriptor_ = -1;
  std::filesystem::path path_;
};

/// Makes names that were made or removed in the folder durable.
void sync_folder(const std::filesystem::path& folder);

}  // namespace tessera::server
