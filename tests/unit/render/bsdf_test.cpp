#include "worker/render/bsdf/bsdf.hpp"

#include <gtest/gtest.h>

#include <cmath>

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

Closure closure_of(std::initializer_list<Lobe> lobes, const Vec3& normal = {0, 0, 1}) {
  Closure closure;
  closure.clear();
  closure.normal = normal;
  closure.shading = Frame(normal);
  for (const Lobe& lobe : lobes) closure.add(lobe);
  return closure;
}

Vec3 from_angles(float cos_theta, float azimuth) {
  const float s = std::sqrt(1 - cos_theta * cos_theta);
  return {s * std::cos(azimuth), s * std::sin(azimuth), cos_theta};
}

/// All directions: (1 + cos θ)/2 against the shading normal, and the azimuth. Delta lobes count as
/// nothing.
test::Chi2Case directions(const Closure& closure, const Vec3& wo) {
  test::Chi2Case test;
  test.bins_s = 20;
  test.sample = [closure, wo](test::Random& random) -> std::optional<Vec2> {
    const float u_lobe = random.next();
    const BsdfSample drawn = sample(closure, wo, u_lobe, random.next2());
    if (!drawn || drawn.specular) return std::nullopt;
    EXPECT_GT(pdf(closure, wo, drawn.wi), 0);
    EXPECT_NEAR(drawn.pdf, pdf(closure, wo, drawn.wi), 1e-4F * drawn.pdf + 1e-6F);
    // The weight is f·cos/pdf, cosine included.
    const Color f = eval(closure, wo, drawn.wi);
    EXPECT_NEAR(f.g, drawn.weight.g * drawn.pdf, 1e-4F * f.g + 1e-6F);
    const Vec3 local = closure.shading.to_local(drawn.wi);
    const float azimuth = std::atan2(local.y, local.x) / (2 * pi);
    return Vec2{0.5F * (1 + local.z), azimuth < 0 ? azimuth + 1 : azimuth};
  };
  test.density = [closure, wo](double s, double t) {
    const double z = 2 * s - 1, r = std::sqrt(std::max(0.0, 1 - z * z));
    const Vec3d local{r * std::cos(2 * M_PI * t), r * std::sin(2 * M_PI * t), z};
    return 4 * M_PI *
           static_cast<double>(pdf(closure, wo, closure.shading.to_world(to_float(local))));
  };
  return test;
}

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
