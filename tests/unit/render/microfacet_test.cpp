#include "worker/render/bsdf/microfacet.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/render/bsdf_support.hpp"
#include "worker/render/bsdf/brushed_energy.hpp"
#include "worker/render/bsdf/energy.hpp"

namespace tessera::render {
namespace {

using test::closure_of, test::directions, test::distance, test::from_angles, test::furnace;

const Reflectance white{gray(1), {}, {}};

Lobe lobe(const Reflectance& reflectance, float alpha_x, float alpha_y, const Vec3& wo,
          bool through = false) {
  const ggx::Roughness roughness{alpha_x, alpha_y};
  return microfacet::lobe_of(microfacet::surface_of(reflectance, roughness),
                             microfacet::view_of(roughness, energy::slant_of(wo)), through);
}
/// What bounces once alone.
Lobe single(Lobe of) {
  of.multiple = {};
  of.multiple_share = 0;
  return of;
}

TEST(Microfacet, SamplesFollowTheirDensity) {
  const struct {
    float x, y, cosine;
  } cases[] = {{0.5F, 0.5F, 0.9F},
               {0.2F, 0.2F, 0.3F},
               {1, 1, 0.6F},
               {0.3F, 0.9F, 0.5F},
               {0.6F, 0.15F, -0.7F}};
  for (const auto& one : cases) {
    const Vec3 wo = from_angles(one.cosine, 0.8F);
    for (const bool through : {false, true}) {
      test::Chi2Case test = directions(closure_of({lobe(white, one.x, one.y, wo, through)}), wo);
      test.quadrature = 4;
      test.samples = 200'000;
      EXPECT_EQ(test::chi2_test(test), "") << one.x << ' ' << one.y << ' ' << one.cosine;
      test = directions(closure_of({single(lobe(white, one.x, one.y, wo, through))}), wo);
      test.quadrature = 4;
      test.samples = 200'000;
      EXPECT_EQ(test::chi2_test(test), "") << "single bounces, " << one.x;
    }
  }
}

TEST(Microfacet, SingleBouncesHaveTheKnownAlbedo) {
  const struct {
    float alpha;
    double albedo;
  } cases[] = {{0.1F, 0.9883}, {0.25F, 0.9158}, {0.5F, 0.6878}, {0.75F, 0.4639}, {1, 0.3069}};
  for (const auto& one : cases) {
    const auto found =
        furnace(closure_of({single(lobe(white, one.alpha, one.alpha, {0, 0, 1}))}), {0, 0, 1});
    EXPECT_NEAR(found.mean, one.albedo, 1e-4 + 4 * found.error) << one.alpha;
    EXPECT_LT(found.error, 1.5e-3);
    EXPECT_NEAR(energy::reflection(1, one.alpha), one.albedo, 1.2e-3) << one.alpha;
  }
}

TEST(Microfacet, WhiteReflectsAllAtEveryRoughness) {
  for (const float roughness :
       {0.02F, 0.05F, 0.1F, 0.15F, 0.23F, 0.31F, 0.4F, 0.5F, 0.61F, 0.7F, 0.8F, 0.9F, 1.0F}) {
    const float alpha = roughness * roughness;
    for (const float cosine : {1.0F, 0.8F, 0.5F, 0.2F, 0.05F, -0.6F}) {
      for (const bool through : {false, true}) {
        const Vec3 wo = from_angles(cosine, 1);
        const auto found = furnace(closure_of({lobe(white, alpha, alpha, wo, through)}), wo);
        EXPECT_NEAR(found.mean, 1, 0.005) << roughness << ' ' << cosine;
        EXPECT_LT(found.error, 0.0022) << roughness << ' ' << cosine;
      }
    }
  }
}

TEST(Microfacet, WhiteReflectsAllAlsoWhereItIsBrushed) {
  // glTF's pairs of roughness and strength, and what lies between; along the brushing and across.
  const struct {
    float x, y;
  } cases[] = {{1, 0.01F},      {1, 0.25F},     {0.64F, 0.01F}, {0.62F, 0.25F}, {0.52F, 0.09F},
               {0.3F, 0.0025F}, {0.37F, 0.17F}, {0.1F, 0.02F},  {0.25F, 0.81F}, {0.05F, 1}};
  for (const auto& one : cases) {
    for (const float cosine : {1.0F, 0.6F, 0.2F, 0.08F, -0.6F}) {
      for (const float azimuth : {0.0F, 0.4F, 0.8F, 1.2F, 0.5F * pi, 2.5F, -0.7F}) {
        const Vec3 wo = from_angles(cosine, azimuth);
        const auto found = furnace(closure_of({lobe(white, one.x, one.y, wo)}), wo, 280);
        EXPECT_NEAR(found.mean, 1, 0.005)
            << one.x << ' ' << one.y << ' ' << cosine << ' ' << azimuth;
        EXPECT_LT(found.error, 0.004) << one.x << ' ' << one.y << ' ' << cosine;
      }
    }
  }
}

TEST(Microfacet, ABrushedSurfaceIsNearlyAnEvenOneWhereItIsNearlyEven) {
  for (const float alpha : {0.05F, 0.3F, 0.9F}) {
    for (const float cosine : {1.0F, 0.4F, 0.1F}) {
      const energy::Slant slant{cosine, 0.3F};
      EXPECT_NEAR(energy::bounce(slant, {alpha, 0.9999F * alpha}).albedo,
                  energy::bounce(slant, {alpha, alpha}).albedo, 0.005)
          << alpha << ' ' << cosine;
    }
    EXPECT_NEAR(energy::reflection_mean({alpha, 0.9999F * alpha}),
                energy::reflection_mean({alpha, alpha}), 0.004);
  }
  // What is brushed along y sees y as what is brushed along x sees x.
  EXPECT_EQ(energy::bounce({0.5F, 0.25F}, {0.2F, 0.7F}).albedo,
            energy::bounce({0.5F, 0.75F}, {0.7F, 0.2F}).albedo);
}

TEST(Microfacet, ARowOfOneRoughnessHasTheTablesBits) {
  for (const float alpha : {0.0F, 1e-4F, 0.013F, 0.3F, 0.77F, 1.0F, 1.5F}) {
    const energy::BounceRow row(alpha);
    for (int i = 0; i <= 1000; ++i) {
      const float cosine = static_cast<float>(i) / 1000;
      const energy::Bounce expected = energy::bounce(cosine, alpha), found = row.at(cosine);
      ASSERT_EQ(found.albedo, expected.albedo) << alpha << ' ' << cosine;
      ASSERT_EQ(found.schlick, expected.schlick) << alpha << ' ' << cosine;
    }
  }
}

TEST(Microfacet, ItsAlbedoIsWhatItReflects) {
  const Reflectance gold = conductor_reflectance({0.15F, 0.4F, 1.4F}, {3.9F, 2.4F, 1.8F});
  for (const Reflectance& reflectance : {gold, schlick_reflectance({0.9F, 0.04F, 0.3F}, gray(1)),
                                         schlick_reflectance(gray(0.3F), gray(0.3F))}) {
    for (const float alpha : {0.02F, 0.2F, 0.6F, 1.0F}) {
      for (const float cosine : {1.0F, 0.5F, 0.1F}) {
        for (const float alpha_y : {alpha, 0.3F * alpha}) {
          const Vec3 wo = from_angles(cosine, 0.4F);
          const auto found = furnace(closure_of({lobe(reflectance, alpha, alpha_y, wo)}), wo);
          const ggx::Roughness roughness{alpha, alpha_y};
          const Color expected =
              microfacet::albedo(microfacet::surface_of(reflectance, roughness),
                                 microfacet::view_of(roughness, energy::slant_of(wo)));
          EXPECT_NEAR(found.mean, expected.g, 0.012) << alpha << ' ' << cosine;
          if (is_black(reflectance.dip)) {
            EXPECT_LT(distance(found.all, expected), 0.012) << alpha << ' ' << cosine;
          }
        }
      }
    }
  }
}

TEST(Microfacet, ThereAndBackAreTheSame) {
  // wo's part of the later bounces stands in the lobe, so each direction has its own.
  test::Random random(8);
  for (const float alpha_y : {0.7F, 0.3F}) {
    for (int i = 0; i < 500; ++i) {
      const Vec3 a = square_to_cosine_hemisphere(random.next2());
      const Vec3 b = square_to_cosine_hemisphere(random.next2());
      const Reflectance f = schlick_reflectance({0.9F, 0.5F, 0.1F}, gray(1));
      const Color there = microfacet::scattering(lobe(f, 0.7F, alpha_y, a), a, b).value / b.z;
      const Color back = microfacet::scattering(lobe(f, 0.7F, alpha_y, b), b, a).value / a.z;
      EXPECT_LT(distance(there, back), 4e-4 * static_cast<double>(max_component(there)))
          << a.z << ' ' << b.z;
    }
  }
}

TEST(Microfacet, TooSmoothItIsAMirrorThatFresnelDarkens) {
  const Reflectance f = schlick_reflectance(gray(0.04F), gray(1));
  const Lobe smooth = lobe(f, 0, 0, from_angles(0.3F, 1));
  EXPECT_EQ(smooth.kind, LobeKind::mirror);
  EXPECT_NEAR(smooth.weight.g, 0.04 + 0.96 * std::pow(0.7, 5), 1e-6);
  EXPECT_EQ(smooth.tint, gray(0.04F));
}

TEST(Reflectance, MeetsAConductorsFresnelWhereItIsFitted) {
  const struct {
    float eta, k;
  } cases[] = {{0.15F, 3.6F}, {1.1F, 2.4F}, {2.9F, 3.0F}, {1.2F, 7.0F}};
  for (const auto& one : cases) {
    const Reflectance f = conductor_reflectance(gray(one.eta), gray(one.k));
    for (const double cosine : {1.0, 1.0 / 7}) {
      EXPECT_NEAR(f.at(static_cast<float>(cosine)).r, fresnel_conductor(cosine, one.eta, one.k),
                  1e-5);
    }
    EXPECT_NEAR(f.at(0).r, 1, 1e-5);
    double most = 0, mean = 0;
    for (int i = 0; i < 1000; ++i) {
      const double c = (i + 0.5) / 1000, exact = fresnel_conductor(c, one.eta, one.k);
      most = std::max(most, std::abs(exact - static_cast<double>(f.at(static_cast<float>(c)).r)));
      mean += 2 * c * static_cast<double>(f.at(static_cast<float>(c)).r) / 1000;
    }
    EXPECT_LT(most, 0.02);
    EXPECT_NEAR(f.mean().r, mean, 1e-4);
  }
}

}  // namespace
}  // namespace tessera::render
