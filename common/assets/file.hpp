#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <utility>

/// Files by descriptor, with errors that name them. For this folder alone.
namespace tessera::assets {

/// An open file; closed when it goes.
class File {
 public:
  File() = default;
  /// `flags` as for open(2); close-on-exec always. Throws Error{not_found or failed}.
  File(const std::filesystem::path& path, int flags);
  ~File();
  File(File&& other) noexcept : path_(std::move(other.path_)), fd_(std::exchange(other.fd_, -1)) {}
  File& operator=(File&& other) noexcept;

  [[nodiscard]] bool is_open() const { return fd_ >= 0; }
  [[nodiscard]] int fd() const { return fd_; }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::uint64_t size() const;
  void write_at(std::span<const std::byte> bytes, std::uint64_t offset);
  void truncate(std::uint64_t size);
  void sync();
  /// Waits for the file's lock (flock), which this descriptor then holds until it is closed.
  void lock();
  /// False if another descriptor holds it.
  bool try_lock();

 private:
  std::filesystem::path path_;
  int fd_ = -1;
};

/// Makes names in this folder survive a power cut.
void sync_folder(const std::filesystem::path& folder);

}  // namespace tessera::assets
