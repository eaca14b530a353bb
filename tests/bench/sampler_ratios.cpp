#include "tests/bench/sampler_ratios.hpp"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "common/base/thread_clock.hpp"
#include "common/scene/scene_file.hpp"
#include "worker/render/integrators/integrator.hpp"
#include "worker/render/render_task.hpp"
#include "worker/render/sampler.hpp"
#include "worker/render/sampler_pcg.hpp"
#include "worker/render/sampler_xorshift.hpp"
#include "worker/scene/build.hpp"

namespace tessera::render {
namespace {

/// Something that is done again and again, and how long one of it took.
struct Subject {
  std::string name;
  std::function<double()> seconds_of_one;
};

/// Prints each subject's median in `unit` (1 s is `scale` of it), and beside it the median of its
/// ratios to the first within each round: what disturbs a round disturbs both.
void compare(const std::vector<Subject>& subjects, int rounds, double scale,
             const std::string& unit) {
  std::vector<std::vector<double>> took(subjects.size());
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t i = 0; i < subjects.size(); ++i) {
      took[i].push_back(subjects[i].seconds_of_one());
    }
  }
  const auto median = [](std::vector<double> values) {
    std::nth_element(values.begin(),
                     values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
    return values[values.size() / 2];
  };
  for (std::size_t i = 0; i < subjects.size(); ++i) {
    std::vector<double> ratios;
    for (std::size_t k = 0; k < took[i].size(); ++k) ratios.push_back(took[i][k] / took[0][k]);
    fmt::print("{} {:.4g} {}\n", subjects[i].name, median(took[i]) * scale, unit);
    fmt::print("{}_ratio {:.4g} times\n", subjects[i].name, median(std::move(ratios)));
  }
  std::fflush(stdout);
}

/// Keeps what is computed from being left out.
volatile std::uint32_t sink;

double seconds_of_addressed_number(SamplerKind kind) {
  constexpr std::uint32_t draws = 20'000;
  std::uint32_t mixed = 0;
  const double began = thread_cpu_seconds();
  for (std::uint32_t i = 0; i < draws; ++i) {
    const Sampler sampler(kind, 1, 100, 200, i);
    const Draw4 draw = sampler.draw4(dim::bsdf_set(i % 4));
    mixed ^= draw.bits(0) ^ draw.bits(1) ^ draw.bits(2) ^ draw.bits(3);
  }
  const double took = thread_cpu_seconds() - began;
  sink = mixed;
  return took / (4.0 * draws);
}

template <class Generator>
double seconds_of_streamed_number(Generator& generator) {
  constexpr int numbers = 2'000'000;
  std::uint32_t mixed = 0;
  const double began = thread_cpu_seconds();
  for (int i = 0; i < numbers; ++i) mixed ^= static_cast<std::uint32_t>(generator());
  const double took = thread_cpu_seconds() - began;
  sink = mixed;
  return took / numbers;
}

void compare_numbers() {
  std::vector<Subject> subjects;
  for (const std::string_view name : sampler_names()) {
    const SamplerKind kind = sampler_kind(name);
    subjects.push_back({fmt::format("number_addressed_{}", name),
                        [kind] { return seconds_of_addressed_number(kind); }});
  }
  std::mt19937 twister(1);
  Xorshift128 xorshift;
  Pcg32 pcg(1, 1);
  subjects.push_back(
      {"number_streamed_mt19937", [&] { return seconds_of_streamed_number(twister); }});
  subjects.push_back(
      {"number_streamed_xorshift", [&] { return seconds_of_streamed_number(xorshift); }});
  subjects.push_back({"number_streamed_pcg", [&] { return seconds_of_streamed_number(pcg); }});
  compare(subjects, 15, 1e9, "ns");
}

double seconds_of_sample(const Scene& scene, const std::string& integrator,
                         const std::string& sampler) {
  TaskRequest request;
  request.settings.width = request.settings.height = 96;
  request.settings.integrator = integrator;
  request.settings.sampler = sampler;
  request.window = {0, 0, 96, 96};
  request.samples = {0, 4};
  tbb::task_arena arena(1);
  const auto done = render_task(scene, request, arena);
  return done->stats.cpu_seconds / static_cast<double>(done->stats.samples);
}

void compare_samples() {
  const char* source = std::getenv("TESSERA_SOURCE_DIR");
  const std::filesystem::path root = source != nullptr ? source : ".";
  const Scene scene =
      worker::build_scene(scene::load_scene(root / "scenes/cornell.json").scene, accel::Device());
  std::vector<Subject> samplers, integrators;
  for (const std::string_view name : sampler_names()) {
    samplers.push_back({fmt::format("cornell_sample_{}", name), [&scene, name] {
                          return seconds_of_sample(scene, "path", std::string(name));
                        }});
  }
  for (const std::string_view name : integrator_names()) {
    integrators.push_back({fmt::format("cornell_sample_by_{}", name), [&scene, name] {
                             return seconds_of_sample(scene, std::string(name), "sobol_owen");
                           }});
  }
  compare(samplers, 9, 1e6, "us");
  compare(integrators, 9, 1e6, "us");
}

}  // namespace

void print_sampler_ratios() {
  compare_numbers();
  compare_samples();
}

}  // namespace tessera::render
