#include "common/image/zip.hpp"

#include <isa-l/igzip_lib.h>

#include <cassert>
#include <cstdint>

#include "common/base/error.hpp"

namespace tessera::image {

std::span<const std::byte> ZipCompressor::compress(std::span<const std::byte> chunk) {
  assert(!chunk.empty() && chunk.size() % 2 == 0);
  const std::size_t half = chunk.size() / 2;
  split_.resize(chunk.size());
  differences_.resize(chunk.size());
  for (std::size_t i = 0; i < half; ++i) {
    split_[i] = chunk[2 * i];
    split_[half + i] = chunk[2 * i + 1];
  }
  differences_[0] = split_[0];
  for (std::size_t i = 1; i < chunk.size(); ++i) {
    const int difference =
        std::to_integer<int>(split_[i]) - std::to_integer<int>(split_[i - 1]) + 128;
    differences_[i] = static_cast<std::byte>(difference & 0xff);
  }

  constexpr std::uint32_t level = 1;
  packed_.resize(chunk.size());
  work_.resize(ISAL_DEF_LVL1_DEFAULT);
  isal_zstream stream{};
  isal_deflate_stateless_init(&stream);
  stream.gzip_flag = IGZIP_ZLIB;
  stream.level = level;
  stream.level_buf = reinterpret_cast<std::uint8_t*>(work_.data());
  stream.level_buf_size = static_cast<std::uint32_t>(work_.size());
  stream.end_of_stream = 1;
  stream.next_in = reinterpret_cast<std::uint8_t*>(differences_.data());
  stream.avail_in = static_cast<std::uint32_t>(differences_.size());
  stream.next_out = reinterpret_cast<std::uint8_t*>(packed_.data());
  stream.avail_out = static_cast<std::uint32_t>(packed_.size());
  const int result = isal_deflate_stateless(&stream);
  if (result == STATELESS_OVERFLOW) return {};
  if (result != COMP_OK) throw Error(ErrorKind::failed, "deflating a picture failed");
  const std::span<const std::byte> packed = std::span(packed_).first(stream.total_out);
  return packed.size() < chunk.size() ? packed : std::span<const std::byte>();
}

}  // namespace tessera::image
