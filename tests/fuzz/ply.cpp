#include "common/scene/ply.hpp"

#include "tests/fuzz/mesh.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tessera;
  fuzz::take_or_refuse(
      [&] { fuzz::check(scene::parse_ply(fuzz::text_of(data, size), "mesh.ply")); });
  return 0;
}
