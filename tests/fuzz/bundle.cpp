#include "common/assets/bundle.hpp"

#include "tests/fuzz/target.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tessera;
  fuzz::take_or_refuse([&] {
    const assets::Bundle bundle = assets::bundle_from_json(fuzz::text_of(data, size));
    fuzz::require(bundle.files.contains(bundle.scene), "a bundle has its scene");
    fuzz::require(assets::bundle_from_json(assets::canonical_json(bundle)) == bundle,
                  "a bundle is the same when it is written and read again");
    (void)assets::total_size(bundle);
  });
  return 0;
}
