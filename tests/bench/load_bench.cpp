// What a scene costs before its first ray: 1.5 million triangles in 24 meshes with 72 pictures,
// from a .glb, each time in a process of its own; and triangles a second from PLY files.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <sstream>

#include "common/base/error.hpp"
#include "common/base/files.hpp"
#include "common/base/thread_clock.hpp"
#include "common/scene/ply.hpp"
#include "scenes/generate/noise.hpp"
#include "scenes/generate/pottery.hpp"
#include "tests/bench/print.hpp"
#include "tests/farm/process.hpp"

using namespace tessera;
using namespace tessera::farm_test;

namespace {

struct Load {
  double read = 0, build = 0, cpu = 0, memory = 0;
};

Load load(const std::filesystem::path& scene, int threads) {
  const Outcome done =
      run({programs() / "bench_load_once", scene.string(), std::to_string(threads)});
  if (done.code != 0) throw Error(ErrorKind::failed, done.errors);
  Load out;
  std::istringstream(done.output) >> out.read >> out.build >> out.cpu >> out.memory;
  return out;
}

void measure_loading(int rounds) {
  const TemporaryFolder folder;
  generate::write_pottery(folder.path(), 1'500'000);
  for (const int threads : {1, 2}) {
    std::vector<Load> loads;
    for (int i = 0; i < rounds; ++i) loads.push_back(load(folder / "pottery.glb", threads));
    const auto least = [&](const std::function<double(const Load&)>& of) {
      double out = of(loads.front());
      for (const Load& one : loads) out = std::min(out, of(one));
      return out;
    };
    double memory = 0;
    for (const Load& one : loads) memory = std::max(memory, one.memory);
    const std::string what = fmt::format("1.5 M triangles, 72 pictures, {} threads: ", threads);
    const char* aim = threads == 2 ? "1.2" : "";
    print(what + "read", least([](const Load& l) { return l.read; }), "s", "");
    print(what + "read and built", least([](const Load& l) { return l.read + l.build; }), "s", aim);
    print(what + "CPU time", least([](const Load& l) { return l.cpu; }), "s", "");
    print(what + "most memory", memory, "MiB", "300");
  }
}

// ---- PLY ----

constexpr std::uint32_t columns = 1000, rows = 500;

std::string header(const char* format) {
  return fmt::format(
      "ply\nformat {} 1.0\nelement vertex {}\nproperty float x\nproperty float y\n"
      "property float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
      format, (columns + 1) * (rows + 1), 2 * columns * rows);
}

/// A hilly ground, vertex by vertex and then triangle by triangle.
std::string ground(const char* format, const std::function<void(std::string&, float)>& number,
                   const std::function<void(std::string&, std::array<std::uint32_t, 3>)>& face) {
  std::string out = header(format);
  for (std::uint32_t j = 0; j <= rows; ++j)
    for (std::uint32_t i = 0; i <= columns; ++i) {
      const double x = 0.01 * i, z = 0.01 * j;
      for (const double value : {x, generate::noise({x, 0.5, z}), z})
        number(out, static_cast<float>(value));
    }
  for (std::uint32_t j = 0; j < rows; ++j)
    for (std::uint32_t i = 0; i < columns; ++i) {
      const std::uint32_t a = j * (columns + 1) + i, b = a + columns + 1;
      face(out, {a, b, b + 1});
      face(out, {a, b + 1, a + 1});
    }
  return out;
}

std::string binary() {
  const auto append = [](std::string& to, const auto& value) {
    std::array<char, sizeof value> bytes;
    std::memcpy(bytes.data(), &value, sizeof value);
    to.append(bytes.data(), bytes.size());
  };
  return ground("binary_little_endian", append, [&](std::string& to, const auto& corners) {
    to.push_back(3);
    append(to, corners);
  });
}

std::string text() {
  return ground(
      "ascii", [](std::string& to, float value) { to += fmt::format("{:.6f} ", value); },
      [](std::string& to, const auto& c) { to += fmt::format("3 {} {} {}\n", c[0], c[1], c[2]); });
}

void measure_ply(const std::string& what, const std::string& bytes, const char* aim, int rounds) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.write("ground.ply", bytes);
  double least = 1e9;
  for (int i = 0; i < rounds; ++i) {
    const double began = thread_cpu_seconds();
    if (scene::read_ply(file, what).triangles.size() != std::size_t{2} * columns * rows)
      throw Error(ErrorKind::failed, "triangles are lacking");
    least = std::min(least, thread_cpu_seconds() - began);
  }
  print(what, 2e-6 * columns * rows / least, "M/s", aim);
}

}  // namespace

/// bench_load [--quick]
int main(int count, char** arguments) {
  try {
    const int rounds = count > 1 && std::string_view(arguments[1]) == "--quick" ? 2 : 7;
    measure_loading(rounds);
    measure_ply("triangles from a binary PLY, a second of CPU time", binary(), "20", rounds);
    measure_ply("triangles from an ASCII PLY, a second of CPU time", text(), "2", rounds);
    return 0;
  } catch (const std::exception& problem) {
    fmt::print(stderr, "bench_load: {}\n", problem.what());
    return 1;
  }
}
