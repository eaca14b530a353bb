// A mesh of Draco's, as a glTF file holds one: position, normal and texture coordinate.
#include "common/scene/gltf/draco.hpp"

#include <algorithm>
#include <array>

#include "tests/fuzz/target.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tessera;
  constexpr int floats = 5126;  // glTF's FLOAT
  constexpr std::array<scene::gltf::DracoAttribute, 3> wanted{
      {{.id = 0, .component_type = floats, .components = 3},
       {.id = 1, .component_type = floats, .components = 3},
       {.id = 2, .component_type = floats, .components = 2}}};
  fuzz::take_or_refuse([&] {
    const scene::gltf::DracoMesh mesh =
        scene::gltf::decode_draco(fuzz::bytes_of(data, size), wanted);
    fuzz::require(std::all_of(mesh.corners.begin(), mesh.corners.end(),
                              [&](std::uint32_t corner) { return corner < mesh.points; }),
                  "corners name points that are there");
    for (std::size_t i = 0; i < wanted.size(); ++i)
      fuzz::require(mesh.attributes[i].size() == mesh.points * wanted[i].components * sizeof(float),
                    "every point has its values");
  });
  return 0;
}
