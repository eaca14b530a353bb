#include "worker/render/bsdf/bsdf.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/render/bsdf_support.hpp"
#include "tests/unit/render/chi2.hpp"
#include "worker/render/bsdf/fresnel.hpp"
#include "worker/render/warp.hpp"

namespace tessera::render {
namespace {

Lobe diffuse_lobe(const Color& albedo) { return {.kind = LobeKind::diffuse, .weight = albedo}; }
Lobe mirror_lobe(const Color& reflectance) {
  return {.kind = LobeKind::mirror, .weight = reflectance};
}
Lobe glass_lobe(float ior) {
  return {.kind = LobeKind::dielectric, .weight = gray(1), .tint = gray(1), .ior = ior};
}

using test::closure_of, test::directions, test::from_angles;

TEST(Bsdf, DiffuseSamplesFollowTheirDensity) {
  for (const float cosine : {1.0F, 0.5F, 0.02F, -0.7F}) {
    EXPECT_EQ(
        test::chi2_test(directions(closure_of({diffuse_lobe(gray(0.5F))}), from_angles(cosine, 1))),
        "")
        << cosine;
  }
}

TEST(Bsdf, MixedLobesFollowTheirDensity) {
  const Vec3 normal = normalize(Vec3{1, -2, 0.5F});
  const Vec3 wo = Frame(normal).to_world(from_angles(0.6F, 2));
  EXPECT_EQ(
      test::chi2_test(directions(
          closure_of({diffuse_lobe({0.5F, 0.1F, 0.2F}), mirror_lobe(gray(0.3F))}, normal), wo)),
      "");
  EXPECT_EQ(test::chi2_test(directions(closure_of({diffuse_lobe({0.1F, 0.6F, 0}),
                                                   diffuse_lobe({0, 0.2F, 0.4F}), glass_lobe(1.5F)},
                                                  normal),
                                       wo)),
            "");
}

TEST(Bsdf, ABentNormalSamplesNothingThroughTheTrueSurface) {
  Closure closure = closure_of({diffuse_lobe(gray(0.8F)), mirror_lobe(gray(0.2F))});
  closure.shading = Frame(normalize(Vec3{0.9F, 0, 0.6F}));
  const Vec3 wo = normalize(Vec3{0.3F, 0.4F, 0.5F});
  test::Chi2Case test = directions(closure, wo);
  test.quadrature = 24;  // the density has a step within bins
  EXPECT_EQ(test::chi2_test(test), "");
  test::Random random(5);
  int below = 0;
  for (int i = 0; i < 10'000; ++i) {
    const float u_lobe = random.next();
    const BsdfSample drawn = sample(closure, wo, u_lobe, random.next2());
    if (drawn) {
      EXPECT_GT(dot(drawn.wi, closure.normal), 0);
    } else {
      ++below;
    }
  }
  EXPECT_GT(below, 100);
}

TEST(Bsdf, NoClosureGivesMoreThanItGets) {
  const Closure closures[] = {closure_of({diffuse_lobe(gray(1))}),
                              closure_of({mirror_lobe(gray(1))}),
                              closure_of({diffuse_lobe(gray(0.4F)), mirror_lobe(gray(0.6F))}),
                              closure_of({glass_lobe(1.5F)}), closure_of({glass_lobe(0.6F)})};
  for (const Closure& closure : closures) {
    for (const float cosine : {1.0F, 0.7F, 0.2F, 0.01F, -0.3F, -0.9F}) {
      const Vec3 wo = from_angles(cosine, 0.4F);
      test::Random random(9);
      double sum = 0;
      constexpr int n = 20'000;
      for (int i = 0; i < n; ++i) {
        const float u_lobe = random.next();
        const BsdfSample drawn = sample(closure, wo, u_lobe, random.next2());
        // Without the radiance's squeeze: energy.
        if (drawn) sum += static_cast<double>(drawn.weight.g * drawn.eta * drawn.eta) / n;
      }
      EXPECT_LT(sum, 1.01);
      EXPECT_GT(sum, 0.99) << "all of these are white";
    }
  }
}

TEST(Bsdf, DiffuseIsReciprocal) {
  const Closure closure =
      closure_of({diffuse_lobe({0.9F, 0.5F, 0.1F}), diffuse_lobe({0, 0.2F, 0.3F})});
  test::Random random(4);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 a = square_to_sphere(random.next2()), b = square_to_sphere(random.next2());
    const Color there = eval(closure, a, b) / std::abs(b.z),
                back = eval(closure, b, a) / std::abs(a.z);
    EXPECT_NEAR(there.r, back.r, 1e-5F);
    EXPECT_NEAR(there.g, back.g, 1e-5F);
    EXPECT_NEAR(there.b, back.b, 1e-5F);
    EXPECT_EQ(is_black(there), a.z * b.z <= 0);
  }
}

Lobe eon_lobe(const Color& albedo, float roughness) {
  return {.kind = LobeKind::eon, .weight = albedo, .tint = gray(1), .alpha_x = roughness};
}

TEST(Bsdf, RoughDiffuseIsLambertsWhereItIsSmooth) {
  const Closure rough = closure_of({eon_lobe({0.9F, 0.5F, 0.1F}, 0)});
  const Closure lambert = closure_of({diffuse_lobe({0.9F, 0.5F, 0.1F})});
  test::Random random(4);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 a = square_to_sphere(random.next2()), b = square_to_sphere(random.next2());
    EXPECT_NEAR(eval(rough, a, b).r, eval(lambert, a, b).r, 1e-6F);
    EXPECT_NEAR(eval(rough, a, b).b, eval(lambert, a, b).b, 1e-6F);
  }
}

TEST(Bsdf, RoughDiffuseLosesNothingAndIsReciprocal) {
  for (const float roughness : {0.3F, 1.0F}) {
    const Closure white = closure_of({eon_lobe(gray(1), roughness)});
    for (const float cosine : {1.0F, 0.5F, 0.1F, -0.4F}) {
      EXPECT_NEAR(test::furnace(white, from_angles(cosine, 1)).mean, 1, 0.002) << cosine;
      if (roughness < 1) {
        EXPECT_EQ(test::chi2_test(directions(white, from_angles(cosine, 1))), "");
      }
    }
    const Closure gray_one = closure_of({eon_lobe(gray(0.5F), roughness)});
    EXPECT_LT(test::furnace(gray_one, {0, 0, 1}).mean, 0.5);
    test::Random random(4);
    for (int i = 0; i < 1000; ++i) {
      const Vec3 a = square_to_sphere(random.next2()), b = square_to_sphere(random.next2());
      const float there = eval(gray_one, a, b).g / std::abs(b.z);
      EXPECT_NEAR(there, eval(gray_one, b, a).g / std::abs(a.z), 1e-4F * there + 1e-6F);
    }
  }
  // Against the light a rough surface is brighter than Lambert's, and darker across.
  const Closure rough = closure_of({eon_lobe(gray(0.5F), 1)});
  const Vec3 wo = from_angles(0.3F, 0);
  EXPECT_GT(eval(rough, wo, from_angles(0.3F, 0)).g, 0.5F * inv_pi * 0.3F);
  EXPECT_LT(eval(rough, wo, from_angles(0.3F, pi)).g, 0.5F * inv_pi * 0.3F);
}

TEST(Bsdf, APaneReflectsByBothFacesAndBendsNothing) {
  const Lobe pane{.kind = LobeKind::pane, .weight = gray(1), .tint = gray(1), .ior = 1.5F};
  const Closure closure = closure_of({pane});
  EXPECT_FALSE(closure.has_smooth);
  for (const float side : {1.0F, -1.0F}) {
    int reflected = 0;
    constexpr int n = 10'000;
    for (int i = 0; i < n; ++i) {
      const Vec3 wo = {0, 0, side};
      const BsdfSample drawn = sample(closure, wo, (static_cast<float>(i) + 0.5F) / n, {});
      ASSERT_TRUE(static_cast<bool>(drawn));
      EXPECT_NEAR(drawn.weight.g, 1, 1e-5F);
      EXPECT_EQ(drawn.eta, 1);
      EXPECT_NEAR(length(drawn.wi - (drawn.transmission ? -wo : wo)), 0, 1e-6F);
      if (!drawn.transmission) ++reflected;
    }
    EXPECT_NEAR(reflected, 0.076923 * n, 1.5);
  }
}

TEST(Bsdf, LobesWithFramesOfTheirOwnFollowTheirDensity) {
  Closure closure = closure_of({diffuse_lobe(gray(0.4F))});
  Lobe coat = diffuse_lobe(gray(0.6F));
  coat.frame = closure.add_frame(Frame(normalize(Vec3{0.5F, 0.1F, 0.8F})));
  closure.add(coat);
  test::Chi2Case test = directions(closure, from_angles(0.7F, 1));
  test.quadrature = 16;  // the density has a step within bins
  EXPECT_EQ(test::chi2_test(test), "");
}

TEST(Bsdf, ScalingALobeScalesWhatItGives) {
  const Vec3 wo = from_angles(0.7F, 1), wi = from_angles(0.5F, 2);
  for (const Lobe& lobe : {diffuse_lobe(gray(0.5F)), eon_lobe(gray(0.5F), 0.7F)}) {
    Closure closure = closure_of({lobe, lobe});
    const float before = eval(closure_of({lobe}), wo, wi).g;
    scale(closure, 1, 0.25F);
    EXPECT_NEAR(eval(closure, wo, wi).g, 1.25F * before, 1e-6F);
    EXPECT_NEAR(closure.pick_sum, closure.pick[0] + closure.pick[1], 1e-7F);
    scale(closure, 1, 0);
    EXPECT_EQ(closure.count, 1);
  }
}

TEST(Bsdf, AMirrorTurnsWoAboutTheNormal) {
  const Vec3 normal = normalize(Vec3{1, 2, 3});
  const Closure closure = closure_of({mirror_lobe({0.9F, 0.8F, 0.7F})}, normal);
  const Vec3 wo = Frame(normal).to_world(from_angles(0.3F, 1));
  const BsdfSample drawn = sample(closure, wo, 0.4F, {0.5F, 0.5F});
  EXPECT_TRUE(drawn.specular);
  EXPECT_FALSE(drawn.transmission);
  EXPECT_EQ(drawn.pdf, 1);
  EXPECT_EQ(drawn.weight, (Color{0.9F, 0.8F, 0.7F}));
  EXPECT_NEAR(length(wo + drawn.wi - normal * (2 * dot(wo, normal))), 0, 1e-5F);
  EXPECT_TRUE(is_black(eval(closure, wo, drawn.wi)));
  EXPECT_EQ(pdf(closure, wo, drawn.wi), 0);
}

TEST(Bsdf, GlassReflectsAsOftenAsFresnelSays) {
  for (const float ior : {1.5F, 0.7F, 1.0F, 2.4F}) {
    for (const float cosine : {1.0F, 0.8F, 0.4F, 0.1F, -0.9F, -0.5F}) {
      const Closure closure = closure_of({glass_lobe(ior)});
      const Vec3 wo = from_angles(cosine, 0.3F);
      const float eta = cosine > 0 ? ior : 1 / ior;
      const double expected =
          static_cast<double>(fresnel_dielectric(std::abs(cosine), eta).reflectance);
      constexpr int n = 40'000;
      int reflected = 0;
      for (int i = 0; i < n; ++i) {
        const BsdfSample drawn = sample(closure, wo, (static_cast<float>(i) + 0.5F) / n, {});
        ASSERT_TRUE(static_cast<bool>(drawn));
        EXPECT_TRUE(drawn.specular);
        EXPECT_NEAR(length(drawn.wi), 1, 1e-5F);
        if (!drawn.transmission) {
          ++reflected;
          EXPECT_GT(drawn.wi.z * wo.z, 0);
          EXPECT_EQ(drawn.eta, 1);
          EXPECT_NEAR(drawn.weight.g, 1, 1e-5F);
        } else {
          EXPECT_LT(drawn.wi.z * wo.z, 0);
          EXPECT_NEAR(drawn.eta, eta, 1e-6F);
          // Snell: the tangential part is divided by eta; radiance is squeezed by eta².
          EXPECT_NEAR(drawn.wi.x * eta, -wo.x, 1e-5F);
          EXPECT_NEAR(drawn.wi.y * eta, -wo.y, 1e-5F);
          EXPECT_NEAR(drawn.weight.g * eta * eta, 1, 1e-5F);
        }
      }
      EXPECT_NEAR(reflected, expected * n, 1.5) << ior << ' ' << cosine;
    }
  }
}

TEST(Bsdf, ThroughGlassAndBackTheRadianceIsWhole) {
  // The same way in reverse: the two squeezes cancel.
  const Closure closure = closure_of({glass_lobe(1.7F)});
  const Vec3 wo = from_angles(0.6F, 1);
  const BsdfSample in = sample(closure, wo, one_minus_epsilon, {});
  const BsdfSample out = sample(closure, in.wi, one_minus_epsilon, {});
  ASSERT_TRUE(in.transmission && out.transmission);
  EXPECT_NEAR(length(out.wi - wo), 0, 1e-5F) << "light's way back is the same";
  EXPECT_NEAR(in.weight.g * out.weight.g, 1, 1e-5F);
  EXPECT_NEAR(in.eta * out.eta, 1, 1e-5F);
}

TEST(Bsdf, TintedGlassKeepsItsMeanWhateverIsChosen) {
  Lobe lobe = glass_lobe(1.5F);
  lobe.weight = {0.2F, 0.5F, 1};
  lobe.tint = {0.9F, 0.1F, 0.3F};
  const Closure closure = closure_of({diffuse_lobe(gray(0.001F)), lobe});
  const Vec3 wo = from_angles(-0.8F, 0);
  const float f = fresnel_dielectric(0.8F, 1 / 1.5F).reflectance;
  Color reflected, refracted;
  constexpr int n = 200'000;
  for (int i = 0; i < n; ++i) {
    const BsdfSample drawn = sample(closure, wo, (static_cast<float>(i) + 0.5F) / n, {0.5F, 0.5F});
    if (drawn.specular) (drawn.transmission ? refracted : reflected) += drawn.weight / n;
  }
  const float squeeze = 1.5F * 1.5F;
  EXPECT_NEAR(reflected.r, 0.2F * f, 1e-4F);
  EXPECT_NEAR(reflected.b, f, 1e-4F);
  EXPECT_NEAR(refracted.r, 0.9F * (1 - f) * squeeze, 3e-3F);
  EXPECT_NEAR(refracted.g, 0.1F * (1 - f) * squeeze, 1e-3F);
}

/// The mean over a cosine-weighted hemisphere, by the midpoint rule in cos² θ.
double mean_fresnel(double eta) {
  constexpr int n = 200'000;
  double sum = 0;
  for (int i = 0; i < n; ++i) {
    const double cosine = std::sqrt((i + 0.5) / n);
    sum += static_cast<double>(
        fresnel_dielectric(static_cast<float>(cosine), static_cast<float>(eta)).reflectance);
  }
  return sum / n;
}

TEST(Fresnel, TheMeanReflectanceIsTheKnownOne) {
  EXPECT_NEAR(mean_fresnel(1.33), 0.065931, 3e-6);
  EXPECT_NEAR(mean_fresnel(1.5), 0.091778, 3e-6);
  EXPECT_NEAR(mean_fresnel(1.8), 0.134054, 3e-6);
  EXPECT_NEAR(mean_fresnel(1 / 1.33), 0.471949, 3e-6);
  EXPECT_NEAR(mean_fresnel(1 / 1.5), 0.596346, 3e-6);
  EXPECT_NEAR(mean_fresnel(1 / 1.8), 0.732733, 3e-6);
}

TEST(Fresnel, KnownAnglesReflectWhatTheyShould) {
  EXPECT_NEAR(fresnel_dielectric(1, 1.5F).reflectance, 0.04F, 1e-6F);
  EXPECT_NEAR(fresnel_dielectric(1, 1 / 1.5F).reflectance, 0.04F, 1e-6F);
  EXPECT_EQ(fresnel_dielectric(0.5F, 1 / 1.5F).reflectance, 1) << "beyond the critical angle";
  EXPECT_EQ(fresnel_dielectric(0, 1.5F).reflectance, 1);
  EXPECT_NEAR(fresnel_dielectric(0.4F, 1).reflectance, 0, 1e-12F);
  // At Brewster's angle only the perpendicular half is reflected: ((eta² − 1)/(eta² + 1))² / 2.
  const float brewster = 1 / std::sqrt(1 + 1.5F * 1.5F);
  EXPECT_NEAR(fresnel_dielectric(brewster, 1.5F).reflectance, 0.5 * std::pow(1.25 / 3.25, 2), 1e-6);
}

TEST(Bsdf, AlbedoIsWhatADenoiserWants) {
  EXPECT_EQ(albedo(closure_of({diffuse_lobe({0.1F, 0.2F, 0.3F})})), (Color{0.1F, 0.2F, 0.3F}));
  EXPECT_EQ(albedo(closure_of({mirror_lobe({0.9F, 0.8F, 0.7F})})), (Color{0.9F, 0.8F, 0.7F}));
  EXPECT_EQ(albedo(closure_of({glass_lobe(1.5F)})), gray(1));
  EXPECT_EQ(albedo(closure_of({glass_lobe(1.5F), diffuse_lobe(gray(0.5F))})), gray(1));
  EXPECT_EQ(albedo(closure_of({})), gray(0));
}

TEST(Bsdf, ABlackClosureScattersNothing) {
  const Closure closure = closure_of({diffuse_lobe({}), mirror_lobe({})});
  EXPECT_EQ(closure.count, 0);
  EXPECT_FALSE(closure.has_smooth);
  EXPECT_FALSE(static_cast<bool>(sample(closure, {0, 0, 1}, 0.5F, {0.5F, 0.5F})));
  EXPECT_EQ(pdf(closure, {0, 0, 1}, {0, 0, 1}), 0);
}

}  // namespace
}  // namespace tessera::render
