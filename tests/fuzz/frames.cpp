// Bytes from a peer on the wire. The first byte says where they are cut in two, and whether the
// peer has been welcomed. They are read as they are, and once more with the right CRC put into
// every frame: else no change would ever be seen behind it.
#include <cstring>
#include <optional>
#include <vector>

#include "common/base/crc32c.hpp"
#include "common/wire/codec.hpp"
#include "common/wire/framing.hpp"
#include "tests/fuzz/target.hpp"

namespace {

using namespace tessera;
using Bytes = std::span<const std::byte>;

void read_all(wire::FrameReader& reader, Bytes bytes) {
  while (const std::optional<wire::Frame> frame = reader.read(bytes)) {
    fuzz::require(frame->body.empty() || wire::has_body(frame->type),
                  "only messages that have a body bring one");
    fuzz::take_or_refuse([&] { (void)wire::decode(frame->type, frame->header); });
  }
  fuzz::require(bytes.empty(), "a reader that waits has taken all bytes");
}

void read_in_two(Bytes bytes, std::size_t cut, bool welcomed) {
  fuzz::take_or_refuse([&] {
    wire::FrameReader reader;
    if (welcomed) reader.welcomed();
    read_all(reader, bytes.first(cut));
    read_all(reader, bytes.subspan(cut));
  });
}

/// With each frame's CRC as it should be.
std::vector<std::byte> mended(Bytes bytes) {
  std::vector<std::byte> out(bytes.begin(), bytes.end());
  for (std::size_t at = 0; out.size() - at >= wire::prefix_bytes + wire::crc_bytes;) {
    std::uint32_t lengths[2];  // of header and body
    std::memcpy(lengths, out.data() + at + 8, sizeof lengths);
    const std::size_t inside =
        wire::prefix_bytes + std::size_t{lengths[0]} + std::min<std::size_t>(lengths[1], 65536);
    if (inside + wire::crc_bytes > out.size() - at) break;
    const std::uint32_t crc = crc32c(Bytes(out).subspan(at, inside));
    std::memcpy(out.data() + at + inside, &crc, sizeof crc);
    at += inside + wire::crc_bytes;
  }
  return out;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const Bytes bytes = fuzz::bytes_of(data + 1, size - 1);
  const std::size_t cut = bytes.size() * (data[0] & 127U) / 128;
  const bool welcomed = (data[0] & 128U) != 0;
  read_in_two(bytes, cut, welcomed);
  read_in_two(mended(bytes), cut, welcomed);
  return 0;
}
