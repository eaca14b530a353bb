#include "tests/fuzz/texels.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  tessera::fuzz::decode(tessera::image::decode_png, data, size);
  return 0;
}
