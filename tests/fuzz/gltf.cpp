// A .gltf or .glb file, which of the two its first bytes say. Beside it lie 256 bytes and a
// picture.
#include <string>

#include "tests/fuzz/memory_file.hpp"
#include "tests/fuzz/scene.hpp"
#include "tests/fuzz/target.hpp"

namespace {

using namespace tessera;

struct Surroundings {
  fuzz::MemoryFile model, data, picture;
  scene::BundleFiles files;

  Surroundings()
      : files({{"model.glb", model.path()}, {"data.bin", data.path()}, {"a.png", picture.path()}}) {
    data.set(std::string(256, '\0'));
    picture.set("picture");
  }
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static Surroundings around;
  around.model.set(fuzz::bytes_of(data, size));
  fuzz::take_or_refuse([&] {
    const scene::LoadedScene loaded = scene::load_scene(around.files, "model.glb");
    fuzz::check(loaded.scene);
    for (const scene::UsedFile& used : loaded.files)
      fuzz::require(around.files.locate(used.path) == used.file,
                    "only the bundle's files are used");
  });
  fuzz::take_or_refuse([&] { (void)scene::survey_scene(around.files, "model.glb"); });
  return 0;
}
