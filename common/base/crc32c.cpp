#include "common/base/crc32c.hpp"

#include <isa-l/crc.h>

#include <algorithm>

namespace tessera {

std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t before) {
  std::uint32_t state = ~before;
  constexpr std::size_t piece = std::size_t{1} << 30;  // the library's length is an int
  while (!bytes.empty()) {
    const auto now = bytes.first(std::min(piece, bytes.size()));
    // The library takes a pointer to mutable bytes, but does not write.
    auto* data = const_cast<unsigned char*>(reinterpret_cast<const unsigned char*>(now.data()));
    state = crc32_iscsi(data, static_cast<int>(now.size()), state);
    bytes = bytes.subspan(now.size());
  }
  return ~state;
}

}  // namespace tessera
