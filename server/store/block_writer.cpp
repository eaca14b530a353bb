#include "server/store/block_writer.hpp"

#include <algorithm>
#include <cstring>

#include "common/base/limits.hpp"

namespace tessera::server {
namespace {

constexpr std::size_t capacity = 4 * limits::MiB;
static_assert(capacity % BlockWriter::block == 0);

}  // namespace

BlockWriter::BlockWriter() : memory_(new (std::align_val_t{block}) std::byte[capacity]) {}

void BlockWriter::start(DiskFile& file, std::uint64_t offset) {
  file_ = &file;
  offset_ = offset;
  filled_ = 0;
}

void BlockWriter::add(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const std::size_t piece = std::min(bytes.size(), capacity - filled_);
    std::memcpy(memory_.get() + filled_, bytes.data(), piece);
    filled_ += piece;
    bytes = bytes.subspan(piece);
    if (filled_ == capacity) write(capacity);
  }
}

std::uint64_t BlockWriter::finish() {
  const std::size_t whole = blocks_end(filled_);
  std::memset(memory_.get() + filled_, 0, whole - filled_);
  if (whole > 0) write(whole);
  return offset_;
}

void BlockWriter::write(std::size_t bytes) {
  file_->write_at(std::span<const std::byte>(memory_.get(), bytes), offset_);
  offset_ += bytes;
  filled_ = 0;
}

}  // namespace tessera::server
