#include "worker/render/bsdf/rough_dielectric.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/render/bsdf_support.hpp"

namespace tessera::render {
namespace {

using test::closure_of, test::directions, test::from_angles, test::furnace;

Lobe lobe(float ior, float alpha_x, float alpha_y, float cos_o) {
  return rough_dielectric::lobe_of({.ior = ior, .roughness = {alpha_x, alpha_y}, .cos_o = cos_o});
}

TEST(RoughDielectric, SamplesFollowTheirDensity) {
  const struct {
    float ior, x, y, cosine;
  } cases[] = {{1.5F, 0.5F, 0.5F, 0.8F},
               {1.5F, 0.3F, 0.3F, -0.6F},
               {1.33F, 1, 1, 0.4F},
               {2.4F, 0.4F, 0.8F, -0.9F},
               {0.7F, 0.35F, 0.35F, 0.5F}};
  for (const auto& one : cases) {
    const Vec3 wo = from_angles(one.cosine, 0.8F);
    Lobe of = lobe(one.ior, one.x, one.y, wo.z);
    ASSERT_EQ(of.kind, LobeKind::rough_dielectric);
    test::Chi2Case test = directions(closure_of({of}), wo);
    test.quadrature = 5;
    test.samples = 300'000;
    EXPECT_EQ(test::chi2_test(test), "") << one.ior << ' ' << one.x << ' ' << one.cosine;
    of.tint = {0.2F, 0.5F, 0.1F};
    test = directions(closure_of({of}), wo);
    test.quadrature = 5;
    test.samples = 300'000;
    EXPECT_EQ(test::chi2_test(test), "") << "tinted, " << one.ior;
  }
}

TEST(RoughDielectric, ClearGlassGivesBackAllAtEveryRoughness) {
  for (const float ior : {1.1F, 1.33F, 1.5F, 2.4F, 0.887F}) {
    for (const float roughness : {0.05F, 0.25F, 0.45F, 0.7F, 1.0F}) {
      const float alpha = roughness * roughness;
      for (const float cosine : {1.0F, 0.5F, 0.08F, -1.0F, -0.5F, -0.08F}) {
        const auto found =
            furnace(closure_of({lobe(ior, alpha, alpha, cosine)}), from_angles(cosine, 1), 200);
        EXPECT_NEAR(found.mean, 1, 0.005 + 3 * found.error)
            << ior << ' ' << roughness << ' ' << cosine;
        EXPECT_LT(found.error, 0.0045) << ior << ' ' << roughness << ' ' << cosine;
      }
    }
  }
}

TEST(RoughDielectric, ThereAndBackAreTheSame) {
  test::Random random(8);
  for (const float ior : {1.5F, 0.7F, 2.2F}) {
    for (int i = 0; i < 1000; ++i) {
      const Vec3 a = square_to_sphere(random.next2()), b = square_to_sphere(random.next2());
      const float index_a = a.z > 0 ? 1 : ior, index_b = b.z > 0 ? 1 : ior;
      // f(a, b)/η_a² = f(b, a)/η_b², f being radiance's (Veach 1997, section 5.2).
      const float energy_there =
          rough_dielectric::scattering(lobe(ior, 0.5F, 0.5F, a.z), a, b).value.g / std::abs(b.z) /
          (index_a * index_a);
      const float energy_back =
          rough_dielectric::scattering(lobe(ior, 0.5F, 0.5F, b.z), b, a).value.g / std::abs(a.z) /
          (index_b * index_b);
      EXPECT_NEAR(energy_there, energy_back, 1e-3F * (energy_there + energy_back) + 1e-6F)
          << ior << ' ' << a.z << ' ' << b.z;
    }
  }
}

TEST(RoughDielectric, NearlySmoothItIsTheSmoothOne) {
  EXPECT_EQ(lobe(1.5F, 0, 0, 1).kind, LobeKind::dielectric);
  EXPECT_EQ(lobe(1, 0.5F, 0.5F, 1).kind, LobeKind::dielectric) << "nothing is bent";
  // Of light straight on, .04 is reflected.
  const Closure closure = closure_of({lobe(1.5F, 1e-3F, 1e-3F, 1)});
  test::Random random(3);
  int reflected = 0;
  constexpr int n = 100'000;
  for (int i = 0; i < n; ++i) {
    const float u_lobe = random.next();
    const BsdfSample drawn = sample(closure, {0, 0, 1}, u_lobe, random.next2());
    if (drawn && !drawn.transmission) ++reflected;
    if (drawn && drawn.transmission) {
      EXPECT_EQ(drawn.eta, 1.5F);
    }
  }
  EXPECT_NEAR(reflected, 0.04 * n, 4 * std::sqrt(0.04 * n));
}

}  // namespace
}  // namespace tessera::render
