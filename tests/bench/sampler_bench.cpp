#include <benchmark/benchmark.h>

#include <string>
#include <string_view>

#include "tests/bench/sampler_ratios.hpp"
#include "worker/render/filter.hpp"
#include "worker/render/lights/light_table.hpp"
#include "worker/render/sampler.hpp"

/// What random numbers cost, by sampler and integrator (sampler_ratios); then a place in the filter
/// and a direction towards a light. `--ratios` stops before the latter.
namespace tessera::render {
namespace {

void draw_filter(benchmark::State& state, FilterKind kind) {
  const Filter filter(kind);
  std::uint64_t sample = 0;
  for (auto _ : state) {
    const Sampler sampler(SamplerKind::independent, 1, 100, 200, ++sample);
    benchmark::DoNotOptimize(filter.sample(sampler.draw2(0)));
  }
}

void draw_light(benchmark::State& state, const Light& light) {
  std::uint64_t sample_index = 0;
  for (auto _ : state) {
    const Sampler sampler(SamplerKind::independent, 1, 100, 200, ++sample_index);
    const Draw4 u = sampler.draw4(0);
    benchmark::DoNotOptimize(sample(light, {.p = {u[2], u[3], 0}, .n = {0, 0, 1}}, u.pair(0)));
  }
}
void ask_light(benchmark::State& state, const Light& light) {
  std::uint32_t i = 0;
  for (auto _ : state) {
    const LightContext context{.p = {static_cast<float>(++i & 7) * 0.1F, 0, 0}, .n = {0, 0, 1}};
    benchmark::DoNotOptimize(pdf(light, context, {.wi = {0, 0, 1}, .distance = 3}));
  }
}

void register_all() {
  for (const std::string_view name : filter_names()) {
    benchmark::RegisterBenchmark(("filter/" + std::string(name)).c_str(), draw_filter,
                                 filter_kind(name));
  }
  const struct {
    const char* name;
    Light light;
  } lights[] = {
      {"rectangle", {.shape = QuadLight{{-1, -1, 3}, {0, 2, 0}, {2, 0, 0}}, .radiance = gray(1)}},
      {"parallelogram",
       {.shape = QuadLight{{-1, -1, 3}, {1, 2, 0}, {2, 0, 0}}, .radiance = gray(1)}},
      {"triangle",
       {.shape = TriangleLight{{-1, -1, 3}, {-1, 1, 3}, {1, -1, 3}}, .radiance = gray(1)}},
      {"sphere", {.shape = SphereLight{{0, 0, 3}, 1}, .radiance = gray(1)}},
      {"environment", {.shape = EnvironmentLight{}, .radiance = gray(1)}},
  };
  for (const auto& entry : lights) {
    benchmark::RegisterBenchmark((std::string("light_sample/") + entry.name).c_str(), draw_light,
                                 entry.light);
    benchmark::RegisterBenchmark((std::string("light_pdf/") + entry.name).c_str(), ask_light,
                                 entry.light);
  }
}

}  // namespace
}  // namespace tessera::render

int main(int argc, char** argv) {
  tessera::render::print_sampler_ratios();
  if (argc > 1 && std::string_view(argv[1]) == "--ratios") return 0;
  tessera::render::register_all();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
}
