#pragma once
#include <cstddef>
#include <span>
#include <vector>

namespace tessera::image {

/// EXR's ZIP compression of one chunk: bytes split into even and odd, each replaced by its
/// difference to the one before, then deflated into a zlib stream, by ISA-L's igzip.
class ZipCompressor {
 public:
  /// The compressed chunk (of an even number of bytes, at least two), or nothing if it would not be
  /// smaller: the format then wants the chunk as it is. Valid until the next call.
  std::span<const std::byte> compress(std::span<const std::byte> chunk);

 private:
  std::vector<std::byte> differences_, packed_, work_;
};

}  // namespace tessera::image
