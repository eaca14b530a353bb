#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <span>

#include "server/store/disk.hpp"

namespace tessera::server {

/// Gathers bytes into whole blocks of aligned memory and writes them one after another: the form
/// that a file takes which bypasses the system's page cache (File::bypass_cache), and that any
/// other takes as well.
class BlockWriter {
 public:
  /// Of which offsets and lengths are multiples: the largest that common disks and file systems ask
  /// for.
  static constexpr std::size_t block = 4096;
  static constexpr std::uint64_t blocks_end(std::uint64_t bytes) {
    return (bytes + block - 1) / block * block;
  }

  BlockWriter();

  /// What is added next begins at `offset`, a multiple of `block`. What was added and not finished
  /// is forgotten.
  void start(DiskFile& file, std::uint64_t offset);
  /// Throws Error as DiskFile::write_at does; then start() must follow.
  void add(std::span<const std::byte> bytes);
  /// Fills the last block with zeros and writes what is left; gives back where the blocks end.
  std::uint64_t finish();

 private:
  void write(std::size_t bytes);

  struct Release {
    void operator()(std::byte* memory) const {
      ::operator delete[](memory, std::align_val_t{block});
    }
  };
  std::unique_ptr<std::byte[], Release> memory_;
  std::size_t filled_ = 0;
  DiskFile* file_ = nullptr;
  std::uint64_t offset_ = 0;  // of memory_'s first byte
};

}  // namespace tessera::server
