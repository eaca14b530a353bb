// Our own scene files. Beside them lie a mesh of each kind, a picture and a glTF file.
#include <algorithm>

#include "tests/fuzz/memory_file.hpp"
#include "tests/fuzz/scene.hpp"
#include "tests/fuzz/target.hpp"

namespace {

using namespace tessera;

struct Surroundings {
  fuzz::MemoryFile obj, ply, gltf, picture;
  scene::BundleFiles files;

  Surroundings()
      : files({{"a.obj", obj.path()},
               {"a.ply", ply.path()},
               {"a.gltf", gltf.path()},
               {"a.png", picture.path()}}) {
    obj.set("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    ply.set(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    gltf.set(
        R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
            "nodes": [{"camera": 0, "mesh": 0}], "materials": [{"name": "red"}],
            "cameras": [{"type": "perspective", "name": "c", "perspective": {"yfov": 1, "znear": 1}}],
            "meshes": [{"name": "m", "primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
            "accessors": [{"count": 3, "componentType": 5126, "type": "VEC3", "bufferView": 0}],
            "bufferViews": [{"buffer": 0, "byteLength": 36}],
            "buffers": [{"byteLength": 36, "uri":
             "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})");
    picture.set("picture");
  }
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Surroundings around;
  fuzz::take_or_refuse([&] {
    fuzz::check(scene::parse_scene(fuzz::text_of(data, size), "scene.json", around.files));
  });
  return 0;
}
