// What is asked for many samples at once has the bits of what is asked for each alone.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <tuple>
#include <vector>

#include "tests/unit/render/bsdf_support.hpp"
#include "tests/unit/render/chi2.hpp"
#include "worker/render/bsdf/bsdf_batch.hpp"
#include "worker/render/lights/light_table.hpp"

namespace tessera::render {
namespace {

Vec3 point_in_box(test::Random& random, float half) {
  return {(random.next() * 2 - 1) * half, (random.next() * 2 - 1) * half,
          (random.next() * 2 - 1) * half};
}
Vec3 direction(test::Random& random) {
  return test::from_angles(random.next() * 2 - 1, random.next() * 2 * pi);
}

/// All that a sample says.
auto all_of(const LightSample& s) {
  return std::tuple(s.wi, s.distance, s.radiance, s.pdf, s.delta, s.light, s.instance, s.primitive);
}

/// Which of those that follow is a mere line.
constexpr std::uint32_t line_light = 13;
/// Every shape; of quads also slanted ones, a mere line, one that is too small for its solid angle.
std::vector<Light> lights_of_every_kind() {
  std::vector<Light> lights;
  const auto add = [&](auto shape, float radiance, bool two_sided = false) {
    Light light{.shape = shape, .radiance = gray(radiance), .two_sided = two_sided};
    light.instance = static_cast<std::uint32_t>(lights.size());
    light.primitive = static_cast<std::uint32_t>(3 * lights.size());
    lights.push_back(light);
  };
  for (int i = 0; i < 6; ++i) {
    const auto x = static_cast<float>(i) - 3;
    add(QuadLight({x, 2, -1}, {1, 0, 0}, {0, 0, 2}), 3);
    add(QuadLight({x, -2, -1}, {0.5F, 0, 0.5F}, {-0.5F, 0, 0.5F}), 2, true);
  }
  add(QuadLight({0, 1, 2}, {1, 0, 0}, {0.5F, 1, 0}), 2, true);
  add(QuadLight({4, 1, 2}, {1, 0, 0}, {2, 0, 0}), 5);
  add(QuadLight({0, 3, 0}, {1e-3F, 0, 0}, {0, 0, 1e-3F}), 1e6F, true);
  add(TriangleLight{{3, 0, 0}, {3, 1, 0}, {3, 0, 1}}, 4, true);
  add(SphereLight{{0, 0, -3}, 0.4F}, 2);
  add(DiskLight({-3, 0, 0}, {0, 0.5F, 0}, {0, 0, 0.5F}), 3, true);
  add(PointLight{{1, 1, 1}}, 2);
  add(SpotLight{.position = {-1, 2, 0}, .axis = {0, -1, 0}}, 9);
  add(DirectionalLight{}, 1);
  add(SunLight{.cap = 1e-4}, 20);
  add(EnvironmentLight{{}, 10}, 0.3F);
  return lights;
}

TEST(SideBySide, LightSamplesHaveTheBitsOfEachAlone) {
  const LightTable table(lights_of_every_kind());
  test::Random random(5);
  std::array<std::size_t, 32> seen{};
  for (int round = 0; round < 20'000; ++round) {
    std::array<LightContext, samples_at_once> contexts;
    std::array<LightRequest, samples_at_once> asked;
    std::array<LightSample, samples_at_once> found;
    for (LightSample& stale : found) stale.pdf = 7;
    const std::size_t count = random.bits() % (asked.size() + 1);
    for (std::size_t i = 0; i < count; ++i) {
      contexts[i].p = point_in_box(random, 4);
      if (random.next() < 0.7F) contexts[i].n = direction(random);
      asked[i] = {&contexts[i], random.bits(), random.next2()};
    }
    table.sample({asked.data(), count}, found);
    for (std::size_t i = 0; i < count; ++i) {
      const LightSample alone = table.sample(contexts[i], asked[i].pick_bits, asked[i].u);
      ASSERT_EQ(all_of(found[i]), all_of(alone));
      if (alone) ++seen.at(alone.light);
    }
  }
  for (std::uint32_t light = 0; light < table.size(); ++light)
    EXPECT_EQ(seen.at(light) > 0, light != line_light) << light;
}

TEST(SideBySide, LightSamplesWithoutAnyLightAreNone) {
  const LightTable table;
  const LightContext here;
  const std::array<LightRequest, 2> asked{LightRequest{&here, 1, {}}, LightRequest{&here, 2, {}}};
  std::array<LightSample, 2> found;
  found[0].pdf = found[1].pdf = 3;
  table.sample(asked, found);
  EXPECT_FALSE(found[0] || found[1]);
}

Lobe rough(float alpha_x, float alpha_y, LobeKind kind = LobeKind::microfacet) {
  return {.kind = kind,
          .weight = {0.6F, 0.5F, 0.3F},
          .tint = kind == LobeKind::microfacet ? Color{0.4F, 0.5F, 0.7F} : Color{},
          .alpha_x = alpha_x,
          .alpha_y = alpha_y,
          .multiple = {0.1F, 0.08F, 0.05F},
          .multiple_share = alpha_x > 0.05F ? 0.2F : 0.0F};
}

/// Every kind of lobe, alone and with others, about normals and frames of their own.
std::vector<Closure> closures_of_every_kind() {
  const Lobe diffuse{.kind = LobeKind::diffuse, .weight = {0.5F, 0.4F, 0.3F}};
  const Lobe eon{
      .kind = LobeKind::eon, .weight = {0.5F, 0.4F, 0.3F}, .tint = gray(1), .alpha_x = 0.5F};
  const Lobe mirror{.kind = LobeKind::mirror, .weight = gray(0.4F)};
  const Lobe glass{.kind = LobeKind::dielectric, .weight = gray(1), .tint = gray(1), .ior = 1.5F};
  const Lobe frosted{.kind = LobeKind::rough_dielectric,
                     .weight = gray(1),
                     .tint = gray(1),
                     .ior = 1.5F,
                     .alpha_x = 0.3F,
                     .alpha_y = 0.3F};
  const Lobe metal = rough(0.3F, 0.3F), satin = rough(0.02F, 0.02F), brushed = rough(0.4F, 0.1F);
  const Lobe through = rough(0.2F, 0.2F, LobeKind::microfacet_through);
  const Vec3 up{0, 0, 1}, slanted = normalize(Vec3{0.3F, -0.2F, 0.9F});
  std::vector<Closure> out{
      test::closure_of({}),
      test::closure_of({diffuse}, slanted),
      test::closure_of({eon}),
      test::closure_of({mirror}),
      test::closure_of({glass}),
      test::closure_of({frosted}),
      test::closure_of({metal}, slanted),
      test::closure_of({satin}),
      test::closure_of({brushed}, slanted),
      test::closure_of({through}),
      test::closure_of({metal, diffuse}),
      test::closure_of({satin, metal, diffuse}, slanted),
      test::closure_of({metal, diffuse, through}, slanted),
      test::closure_of({mirror, metal, diffuse}),
      test::closure_of({metal, brushed, eon}, slanted),
      test::closure_of({satin, satin, metal, metal, through, through, diffuse, diffuse}),
  };
  Closure framed = test::closure_of({metal, diffuse}, slanted);
  framed.lobes[0].frame = framed.add_frame(Frame(up));
  out.push_back(framed);
  Closure bent = test::closure_of({metal, satin, diffuse});  // a normal map's normal
  bent.shading = Frame(slanted);
  out.push_back(bent);
  bent.rounded = true;
  bent.round_normal = slanted;
  out.push_back(bent);
  return out;
}

TEST(SideBySide, ClosuresOfNothingAreAnsweredWhereThereIsNoRoom) {
  const Lobe metal = rough(0.3F, 0.3F);
  const Closure full = test::closure_of({metal, metal, metal, metal});
  const Closure empty = test::closure_of({});
  const Vec3 wo{0, 0, 1}, wi = normalize(Vec3{0.2F, 0.1F, 1});
  std::array<ScatteringRequest, samples_at_once> asked;
  std::array<Scattering, samples_at_once> found;
  asked.fill({&full, wo, wi});
  asked.back().closure = &empty;
  BsdfBatch batch;
  for (int round = 0; round < 2; ++round) {
    batch.scattering(asked, found);
    EXPECT_EQ(found[0].pdf, pdf(full, wo, wi));
    EXPECT_EQ(found[samples_at_once - 2].pdf, pdf(full, wo, wi));
    EXPECT_EQ(found.back().pdf, 0);
  }
}

TEST(SideBySide, ScatteringHasTheBitsOfEachAlone) {
  const std::vector<Closure> closures = closures_of_every_kind();
  test::Random random(6);
  BsdfBatch batch;
  std::size_t some = 0;
  for (int round = 0; round < 20'000; ++round) {
    std::array<ScatteringRequest, samples_at_once> asked;
    std::array<Scattering, samples_at_once> found;
    for (Scattering& stale : found) stale.pdf = 7;
    const std::size_t count = random.bits() % (asked.size() + 1);
    for (std::size_t i = 0; i < count; ++i)
      asked[i] = {&closures[random.bits() % closures.size()], direction(random), direction(random)};
    batch.scattering({asked.data(), count}, found);
    for (std::size_t i = 0; i < count; ++i) {
      const Scattering alone = scattering(*asked[i].closure, asked[i].wo, asked[i].wi);
      ASSERT_EQ(found[i].value, alone.value) << asked[i].closure - closures.data();
      ASSERT_EQ(found[i].pdf, alone.pdf);
      some += alone.pdf > 0 ? 1 : 0;
    }
  }
  EXPECT_GT(some, 50'000U);
}

TEST(SideBySide, DirectionsHaveTheBitsOfEachAlone) {
  const std::vector<Closure> closures = closures_of_every_kind();
  test::Random random(7);
  BsdfBatch batch;
  std::vector<std::size_t> drawn_from(closures.size(), 0);
  for (int round = 0; round < 20'000; ++round) {
    std::array<BsdfRequest, samples_at_once> asked;
    std::array<BsdfSample, samples_at_once> found;
    for (BsdfSample& stale : found) stale.pdf = 7;
    const std::size_t count = random.bits() % (asked.size() + 1);
    for (std::size_t i = 0; i < count; ++i)
      asked[i] = {&closures[random.bits() % closures.size()], direction(random), random.next(),
                  random.next2()};
    batch.sample({asked.data(), count}, found);
    for (std::size_t i = 0; i < count; ++i) {
      const BsdfSample alone = sample(*asked[i].closure, asked[i].wo, asked[i].u_lobe, asked[i].u);
      const auto all_of = [](const BsdfSample& s) {
        return std::tuple(s.wi, s.weight, s.pdf, s.kind, s.specular, s.transmission, s.eta);
      };
      ASSERT_EQ(all_of(found[i]), all_of(alone)) << asked[i].closure - closures.data();
      drawn_from[static_cast<std::size_t>(asked[i].closure - closures.data())] += alone ? 1 : 0;
    }
  }
  for (std::size_t i = 1; i < closures.size(); ++i) EXPECT_GT(drawn_from[i], 100U) << i;
}

}  // namespace
}  // namespace tessera::render
