// A message's header; its type stands in the first byte.
#include "common/wire/codec.hpp"
#include "tests/fuzz/target.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tessera;
  if (size == 0) return 0;
  fuzz::take_or_refuse([&] {
    const wire::Message message = wire::decode(data[0], fuzz::text_of(data + 1, size - 1));
    const wire::EncodedMessage encoded = wire::encode(message);
    const wire::EncodedMessage again = wire::encode(wire::decode(encoded.type, encoded.header));
    fuzz::require(encoded.type == data[0] && again.header == encoded.header,
                  "a message that was read can be sent on, and is the same");
  });
  return 0;
}
