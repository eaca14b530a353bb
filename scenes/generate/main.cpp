#include <fmt/format.h>

#include <charconv>
#include <cstdio>
#include <string_view>

#include "common/base/error.hpp"
#include "scenes/generate/asteroid.hpp"

namespace {
constexpr std::size_t triangles_default = 1'200'000;
constexpr std::size_t triangles_most = 200'000'000;
constexpr std::string_view usage =
    "usage: tessera-scenes FOLDER [TRIANGLES]\n"
    "Writes asteroid.json and asteroid.obj, a rock of at least so many triangles (1200000), to the "
    "folder.\n";

int run(int argc, char** argv) {
  if (argc == 2 && std::string_view(argv[1]) == "--help") {
    fmt::print("{}", usage);
    return 0;
  }
  std::size_t triangles = triangles_default;
  bool good = argc == 2 || argc == 3;
  if (argc == 3) {
    const std::string_view text = argv[2];
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), triangles);
    good = error == std::errc() && end == text.data() + text.size() && triangles >= 12 &&
           triangles <= triangles_most;
  }
  if (!good) {
    fmt::print(stderr, "tessera-scenes: wrong arguments\n{}", usage);
    return 2;
  }
  tessera::generate::write_asteroid(argv[1], triangles);
  return 0;
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
