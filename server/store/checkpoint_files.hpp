#pragma once
#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "server/store/disk.hpp"
#include "server/store/records.hpp"

namespace tessera::server {

/// Writes one checkpoint. Dropped without finish() it leaves nothing. One thread at a time.
class CheckpointWriter {
 public:
  /// See CheckpointFiles::begin.
  CheckpointWriter(Disk& disk, const std::filesystem::path& file, bool durable,
                   std::atomic<std::uint64_t>& bytes, const Checkpoint& empty);
  ~CheckpointWriter();
  CheckpointWriter(const CheckpointWriter&) = delete;
  CheckpointWriter& operator=(const CheckpointWriter&) = delete;

  /// Tiles come in ascending order.
  void append(std::uint32_t tile, std::uint32_t passes, std::span<const std::byte> content);
  /// On return all of it is on the disk. It counts once Store::put_checkpoint has taken it.
  Checkpoint finish();

 private:
  void discard() noexcept;
  void count_what_stays() noexcept;

  Disk& disk_;
  bool durable_;
  Checkpoint made_;
  std::unique_ptr<DiskFile> file_;
  bool finished_ = false;
  std::atomic<std::uint64_t>& bytes_;
};

/// The checkpoints on disk: files NUMBER.checkpoint in one folder, each a header (magic, version,
/// job, frame) and then a record a tile: u32 length of the content, u32 CRC-32C of what follows,
/// u32 tile, u32 passes, the content; little-endian. Which files count is the index's to say. Any
/// thread.
class CheckpointFiles {
 public:
  /// The folder must be there.
  CheckpointFiles(Disk& disk, std::filesystem::path folder, bool durable);

  /// Must outlive the writer.
  [[nodiscard]] std::unique_ptr<CheckpointWriter> begin(JobId job, std::int32_t frame);
  /// A tile's content. Throws DamagedError if it is damaged, Error{failed} if it cannot be read.
  [[nodiscard]] std::vector<std::byte> read(const CheckpointPlace& place) const;

  /// None that is begun from here on has this number, or one below it.
  void skip(std::uint64_t number) { last_ = std::max(last_.load(), number); }
  [[nodiscard]] std::set<std::uint64_t> numbers() const;
  struct Found {
    std::uint64_t bytes = 0;
    std::string unseen;  ///< why it could not be looked at
  };
  /// What there was at the start, by number; given once.
  [[nodiscard]] std::map<std::uint64_t, Found> take_found() { return std::move(found_); }
  /// 0 if it is not there.
  [[nodiscard]] std::uint64_t size_of(std::uint64_t number) const;
  [[nodiscard]] std::filesystem::path path_of(std::uint64_t number) const;
  void remove(std::uint64_t number);
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

 private:
  [[nodiscard]] bool is_gone(std::uint64_t number) const noexcept;

  Disk& disk_;
  std::filesystem::path folder_;
  bool durable_;
  std::map<std::uint64_t, Found> found_;
  std::atomic<std::uint64_t> last_{0};
  std::atomic<std::uint64_t> bytes_{0};
};

}  // namespace tessera::server
