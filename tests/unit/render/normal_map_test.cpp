#include "worker/render/bsdf/normal_map.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/render/chi2.hpp"
#include "tests/unit/render/material_support.hpp"
#include "worker/render/warp.hpp"

namespace tessera::render {
namespace {

using test::closure_at, test::of, test::one_texel, test::seen_from;

TEST(NormalMap, WhatMirrorsOutwardsIsLeftAlone) {
  const Vec3 n = normalize(Vec3{0.2F, 0.1F, 1});
  EXPECT_EQ(keep_mirrored_outside(n, {0, 0, 1}, normalize(Vec3{0.1F, 0, 1})), n);
}

TEST(NormalMap, ASurfacesOwnNormalIsLeftAloneAtEveryAngle) {
  for (const float height : {1.0F, 0.01F, 1e-3F, 1e-6F, -1e-3F, -1.0F}) {
    const Vec3 wo = normalize(Vec3{std::sqrt(1 - height * height), 0, height});
    EXPECT_EQ(keep_mirrored_outside({0, 0, 1}, {0, 0, 1}, wo), (Vec3{0, 0, 1})) << height;
  }
}

TEST(NormalMap, NoNormalMirrorsIntoTheSurface) {
  test::Random random(3);
  int bent = 0;
  for (int i = 0; i < 20'000; ++i) {
    const Vec3 wo = square_to_sphere(random.next2());
    const Vec3 n = square_to_hemisphere(random.next2());
    const Vec3 out = keep_mirrored_outside(n, {0, 0, 1}, wo);
    const Vec3 mirrored = out * (2 * dot(out, wo)) - wo;
    EXPECT_NEAR(length(out), 1, 1e-5F);
    EXPECT_GT(mirrored.z * wo.z, 0) << wo.z;
    EXPECT_GT(dot(out, wo) * wo.z, 0);
    EXPECT_GT(out.z, 0);
    if (!(out == n)) ++bent;
  }
  EXPECT_GT(bent, 2000);
  EXPECT_LT(bent, 15'000);
}

TEST(NormalMap, ATexelTurnsTheFrame) {
  const TextureTable textures = one_texel({1, 0.5F, 1, 1});  // (1, 0, 1)
  scene::Material material = of(scene::Diffuse{});
  material.normal_map = scene::NormalMap{};
  EXPECT_EQ(compile(material).wants, detail_flag::uv0 | detail_flag::tangent);
  Closure closure = closure_at(material, {0, 0, 1}, textures);
  EXPECT_NEAR(length(closure.shading.n - normalize(Vec3{1, 0, 1})), 0, 1e-2F);
  material.normal_map->scale = 0;
  closure = closure_at(material, {0, 0, 1}, textures);
  EXPECT_NEAR(length(closure.shading.n - Vec3{0, 0, 1}), 0, 1e-6F);
}

TEST(NormalMap, BendsNothingWhereTheGeometryHasNoTangentsOrNoCoordinates) {
  const TextureTable textures = one_texel({1, 0.5F, 1, 1});
  scene::Principled coated;
  coated.clearcoat.factor = 1;
  coated.clearcoat_roughness.factor = 0.5;
  coated.clearcoat_normal = scene::NormalMap{};
  scene::Material material = of(coated);
  material.normal_map = scene::NormalMap{};
  material.bump_map = scene::BumpMap{};
  ShadingPoint point = seen_from({0, 0, 1});
  for (const int has :
       {detail_flag::color | detail_flag::uv0, detail_flag::color | detail_flag::tangent,
        detail_flag::uv1 | detail_flag::tangent}) {
    point.detail->has = static_cast<std::uint8_t>(has);
    Closure closure;
    evaluate(compile(material), textures, point, closure);
    EXPECT_EQ(closure.shading.n, (Vec3{0, 0, 1})) << has;
    EXPECT_EQ(closure.frame_count, 0) << has;
  }
}

TEST(NormalMap, ItsSetOfCoordinatesGivesTheTangents) {
  const auto map_of = [](std::uint8_t set) { return scene::NormalMap{.texture = {.uv_set = set}}; };
  scene::Principled coated;
  coated.clearcoat.factor = 1;
  coated.clearcoat_normal = map_of(1);
  scene::Material material = of(coated);
  const auto follows = [&] { return tangent_set(compile(material).wants); };
  EXPECT_EQ(follows(), 1U);
  material.bump_map = scene::BumpMap{};
  EXPECT_EQ(follows(), 1U);
  material.normal_map = map_of(0);
  EXPECT_EQ(follows(), 0U);
  material.normal_map = map_of(1);
  EXPECT_EQ(follows(), 1U);
}

TEST(BumpMap, OverAMapOfNormalsItBendsWhatThatHasBent) {
  // Heights that do not change, over a map that leans far; and such as lean beyond the surface.
  const TextureTable textures = one_texel({1, 0.5F, 1, 1});
  scene::Material material = of(scene::Diffuse{});
  material.normal_map = scene::NormalMap{};
  const Vec3 leaning = closure_at(material, {0, 0, 1}, textures).shading.n;
  EXPECT_GT(leaning.x, 0.6F);
  material.bump_map = scene::BumpMap{};
  EXPECT_NEAR(length(closure_at(material, {0, 0, 1}, textures).shading.n - leaning), 0, 1e-6F);
}

TEST(BumpMap, ARampTurnsTheNormalByItsSlope) {
  // Two texels, 0 and 1, read beyond their middles: within, the height is 2u − 1/2.
  image::Texels picture{
      .width = 2, .height = 1, .channels = 1, .format = image::TexelFormat::f32, .bytes = {}};
  const float heights[] = {0, 1};
  picture.bytes.resize(sizeof heights);
  std::memcpy(picture.bytes.data(), heights, sizeof heights);
  Texture texture;
  texture.picture = std::make_shared<Pyramid>(std::move(picture), scene::ColorSpace::linear);
  texture.wrap_u = scene::Wrap::clamp_to_edge;
  const TextureTable textures({texture});
  scene::Material material = of(scene::Diffuse{});
  material.bump_map = scene::BumpMap{.texture = {}, .height = 0.25};
  ShadingPoint point = seen_from({0, 0, 1});
  point.detail->uv[0].uv = {0.5F, 0.5F};
  // u grows by 1/2 per unit of length: the slope is 2·½·¼.
  point.detail->uv[0].by_tangent = {0.5F, 0};
  point.detail->uv[0].by_bitangent = {0, -0.5F};
  Closure closure;
  evaluate(compile(material), textures, point, closure);
  EXPECT_NEAR(length(closure.shading.n - normalize(Vec3{-0.25F, 0, 1})), 0, 1e-5F);
}

}  // namespace
}  // namespace tessera::render
