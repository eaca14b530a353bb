#pragma once
#include <algorithm>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <set>
#include <span>
#include <vector>

#include "server/store/block_writer.hpp"
#include "server/store/disk.hpp"
#include "server/store/records.hpp"

namespace tessera::server {

/// The bulk bytes: append-only files NUMBER.segment in one folder, each a header (magic, version)
/// and then records one after another, those of each append from the start of a block on. What a
/// record's place is, and which records count, is the index's to say: bytes behind the last indexed
/// record are of no meaning. Not const: one thread at a time. Const: any thread.
class Journal {
 public:
  /// Begins a new segment with the first append.
  Journal(Disk& disk, std::filesystem::path folder, bool durable, std::uint64_t segment_bytes);

  /// None that is begun from here on has this number, or one below it.
  void skip(std::uint64_t segment) { number_ = std::max(number_, segment); }
  /// The numbers of the segments on disk.
  [[nodiscard]] std::set<std::uint64_t> segments() const;
  [[nodiscard]] std::uint64_t size_of(std::uint64_t segment) const;
  [[nodiscard]] std::filesystem::path path_of(std::uint64_t segment) const;

  /// Writes the records and syncs once. If it throws, nothing was appended.
  std::vector<ResultPlace> append(std::span<const NewResult> batch);
  /// Takes the last append back, as if it had thrown.
  void undo();
  /// Begins a new segment with the next append: what the last one wrote may be or not be.
  void seal();
  [[nodiscard]] StoredResult read(const ResultPlace& place) const;
  /// Deletes a segment; the current one is kept. One that cannot be deleted is logged.
  void remove(std::uint64_t segment);
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

 private:
  void begin_segment();
  void recount();
  void drop_what_is_old();

  Disk& disk_;
  std::filesystem::path folder_;
  bool durable_;
  std::uint64_t segment_bytes_;
  std::uint64_t number_ = 0;        // of the newest segment
  std::unique_ptr<DiskFile> file_;  // the current one, or none
  BlockWriter blocks_;
  std::uint64_t end_ = 0;     // of its blocks
  std::uint64_t last_ = 0;    // where the last append began
  std::uint64_t cached_ = 0;  // before it the system was told to keep nothing in memory
  std::atomic<std::uint64_t> bytes_{0};
};

}  // namespace tessera::server
