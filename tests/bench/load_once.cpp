// A scene read, its pictures decoded and its hierarchies built as a worker does it, in a process
// that does nothing else: bench_load_once SCENE THREADS prints seconds of reading, of building, of
// all threads' CPU time, and the most memory that the process ever held, MiB.
#include <sys/resource.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <string>

#include "common/scene/scene_file.hpp"
#include "worker/scene/build.hpp"

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point then) {
  return std::chrono::duration<double>(Clock::now() - then).count();
}

double cpu_seconds() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  return static_cast<double>(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
}

/// MiB. Of rusage's figure a part may be that of the process which started this one.
double peak_memory() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmHWM:")) return std::stod(line.substr(6)) / 1024;
  return 0;
}

void load(const char* file, int threads) {
  using namespace tessera;
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  const accel::Device device;
  const auto began = Clock::now();
  arena.execute([&] {
    scene::LoadedScene loaded = scene::load_scene(std::filesystem::path(file));
    const double read = seconds_since(began);
    const render::Scene built = worker::build_scene(std::move(loaded.scene), device);
    const double all = seconds_since(began);
    std::printf("%.4f %.4f %.4f %.1f\n", read, all - read, cpu_seconds(), peak_memory());
  });
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 3) {
    std::fprintf(stderr, "bench_load_once SCENE THREADS\n");
    return 2;
  }
  try {
    load(arguments[1], std::atoi(arguments[2]));
    return 0;
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "bench_load_once: %s\n", problem.what());
    return 1;
  }
}
