// A record of the journal, as it is and with the right CRC.
#include <cstring>
#include <vector>

#include "common/base/crc32c.hpp"
#include "server/store/journal_record.hpp"
#include "tests/fuzz/target.hpp"

namespace {

using namespace tessera;

void parse(std::span<const std::byte> record) {
  fuzz::take_or_refuse([&] {
    const server::StoredResult result = server::parse_record(record);
    const std::vector<std::byte> head = server::record_head(result.info, result.exr);
    fuzz::require(head.size() + result.exr.size() == record.size() &&
                      std::memcmp(head.data(), record.data(), head.size()) == 0,
                  "a record is the same when it is written again");
  });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span<const std::byte> bytes = fuzz::bytes_of(data, size);
  parse(bytes);
  if (size < server::record_prefix) return 0;
  std::vector<std::byte> mended(bytes.begin(), bytes.end());
  const std::uint32_t crc = crc32c(bytes.subspan(server::record_prefix));
  std::memcpy(mended.data() + sizeof crc, &crc, sizeof crc);
  parse(mended);
  return 0;
}
