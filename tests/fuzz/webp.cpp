// WebP packs one colour into nothing: a picture of a gigabyte, which the limit allows, into 30
// bytes. Such a one would take all of the time, so large ones are passed over here.
#include <webp/decode.h>

#include "tests/fuzz/texels.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  int width = 0, height = 0;
  if (WebPGetInfo(data, size, &width, &height) != 0 && std::int64_t{width} * height > 1 << 22)
    return 0;
  tessera::fuzz::decode(tessera::image::decode_webp, data, size);
  return 0;
}
