// Whole pictures in OpenEXR, as the client reads them.
#include "common/image/picture.hpp"

#include "tests/fuzz/target.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tessera;
  fuzz::take_or_refuse([&] {
    const image::ExrImage picture = image::read_exr(fuzz::bytes_of(data, size), "picture");
    fuzz::require(picture.values.size() == picture.channels.size() *
                                               static_cast<std::size_t>(picture.width) *
                                               static_cast<std::size_t>(picture.height),
                  "a picture has all its values");
  });
  return 0;
}
