#include <fmt/format.h>

#include <charconv>
#include <cstdio>
#include <string_view>

#include "common/base/error.hpp"
#include "scenes/generate/asteroid.hpp"
#include "scenes/generate/forest.hpp"
#include "scenes/generate/lake.hpp"
#include "scenes/generate/pottery.hpp"

namespace {

struct Scene {
  std::string_view name;
  void (*write)(const std::filesystem::path& folder, std::size_t size);
  std::size_t usual, least, most;  ///< of its size
};

constexpr Scene scenes[] = {
    {"asteroid", tessera::generate::write_asteroid, 1'200'000, 12, 200'000'000},
    {"forest", tessera::generate::write_forest, 1'000'000, 1, 10'000'000},
    {"lake", tessera::generate::write_lake, 10'000, 1, 1'000'000},
    {"pottery", tessera::generate::write_pottery, 1'500'000, 1, 100'000'000},
};

constexpr std::string_view usage =
    "usage: tessera-scenes SCENE FOLDER [SIZE]\n"
    "Writes a scene that is too large to be kept to the folder:\n"
    "  asteroid   asteroid.json, asteroid.obj: a rock of at least SIZE triangles (1200000)\n"
    "  forest     forest.json, forest.gltf, forest.bin: at least SIZE instances of 20 trees "
    "(1000000)\n"
    "  lake       lake.json: SIZE lanterns on and over a lake at night (10000)\n"
    "  pottery    pottery.glb: 24 pots of at least SIZE triangles in all, with pictures "
    "(1500000)\n";

int refuse(std::string_view what) {
  fmt::print(stderr, "tessera-scenes: {}\n{}", what, usage);
  return 2;
}

int run(int argc, char** argv) {
  if (argc == 2 && std::string_view(argv[1]) == "--help") {
    fmt::print("{}", usage);
    return 0;
  }
  if (argc != 3 && argc != 4) return refuse("expected a scene and a folder");
  for (const Scene& scene : scenes) {
    if (scene.name != argv[1]) continue;
    std::size_t size = scene.usual;
    if (argc == 4) {
      const std::string_view text = argv[3];
      const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), size);
      if (error != std::errc() || end != text.data() + text.size() || size < scene.least ||
          size > scene.most)
        return refuse(fmt::format("expected a size from {} to {}, found \"{}\"", scene.least,
                                  scene.most, text.substr(0, 64)));
    }
    scene.write(argv[2], size);
    return 0;
  }
  return refuse(fmt::format("there is no scene \"{}\"", std::string_view(argv[1]).substr(0, 64)));
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const tessera::Error& error) {
    fmt::print(stderr, "tessera-scenes: {}\n", error.what());
    return tessera::exit_code(error.kind());
  } catch (const std::exception& error) {
    fmt::print(stderr, "tessera-scenes: {}\n", error.what());
    return 1;
  }
}
