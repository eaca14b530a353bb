#include "worker/render/bsdf/material.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tessera::render {
namespace {

Closure at(const scene::Material& material, const Vec3& wo) {
  Closure closure;
  ShadingPoint point;
  point.wo = wo;
  evaluate(compile(material), {}, point, closure);
  return closure;
}

TEST(Material, TheTableHoldsEveryKindOfTheDescription) {
  EXPECT_THAT(material_names(), testing::ElementsAre("diffuse", "mirror", "dielectric", "emitter",
                                                     "conductor", "principled", "mix"));
}

TEST(Material, DiffuseBecomesOneSmoothLobe) {
  const Closure closure = at({"wall", scene::Diffuse{{0.1, 0.2, 0.3}}}, {0, 0, 1});
  ASSERT_EQ(closure.count, 1);
  EXPECT_EQ(closure.lobes[0].kind, LobeKind::diffuse);
  EXPECT_EQ(closure.lobes[0].weight, (Color{0.1F, 0.2F, 0.3F}));
  EXPECT_TRUE(closure.has_smooth);
  EXPECT_EQ(closure.flags, lobe_flag::reflection);
}

TEST(Material, MirrorAndGlassBecomeDeltas) {
  const Closure mirror = at({"m", scene::Mirror{{0.9, 0.8, 0.7}}}, {0, 0, 1});
  ASSERT_EQ(mirror.count, 1);
  EXPECT_EQ(mirror.lobes[0].kind, LobeKind::mirror);
  EXPECT_FALSE(mirror.has_smooth);
  const Closure glass =
      at({"g", scene::Dielectric{1.33, {0.5, 0.6, 0.7}, {0.8, 0.9, 1}}}, {0, 0, 1});
  ASSERT_EQ(glass.count, 1);
  EXPECT_EQ(glass.lobes[0].kind, LobeKind::dielectric);
  EXPECT_FLOAT_EQ(glass.lobes[0].ior, 1.33F);
  EXPECT_EQ(glass.lobes[0].tint, (Color{0.5F, 0.6F, 0.7F}));
  EXPECT_EQ(glass.lobes[0].weight, (Color{0.8F, 0.9F, 1}));
  EXPECT_EQ(glass.flags, lobe_flag::reflection | lobe_flag::transmission | lobe_flag::specular);
}

TEST(Material, AnEmitterEmitsOnItsSides) {
  const scene::Material one{"light", scene::Emitter{{3, 4, 5}, false}};
  EXPECT_EQ(at(one, {0, 0, 1}).emission, (Color{3, 4, 5}));
  EXPECT_EQ(at(one, {0, 0, -1}).emission, Color{});
  EXPECT_EQ(at(one, {0, 0, 1}).count, 0);
  EXPECT_TRUE(compile(one).emits());
  EXPECT_FALSE(compile(one).two_sided);
  const scene::Material both{"light", scene::Emitter{{3, 4, 5}, true}};
  EXPECT_EQ(at(both, {0, 0, -1}).emission, (Color{3, 4, 5}));
  EXPECT_TRUE(compile(both).two_sided);
  EXPECT_FALSE(compile({"wall", scene::Diffuse{}}).emits());
}

TEST(Material, AnEmitterMayScatterToo) {
  const scene::Material both{"light", scene::Emitter{{3, 4, 5}, false, {0.2, 0.4, 0.6}}};
  for (const float side : {1.0F, -1.0F}) {
    const Closure closure = at(both, {0, 0, side});
    ASSERT_EQ(closure.count, 1);
    EXPECT_EQ(closure.lobes[0].kind, LobeKind::diffuse);
    EXPECT_EQ(closure.lobes[0].weight, (Color{0.2F, 0.4F, 0.6F}));
    EXPECT_EQ(closure.emission, side > 0 ? (Color{3, 4, 5}) : Color{});
  }
}

TEST(Material, AClosureIsCleanFromHitToHit) {
  Closure closure;
  ShadingPoint point;
  point.wo = {0, 0, 1};
  evaluate(compile({"light", scene::Emitter{{1, 1, 1}, true}}), {}, point, closure);
  evaluate(compile({"wall", scene::Diffuse{}}), {}, point, closure);
  EXPECT_EQ(closure.emission, Color{});
  EXPECT_EQ(closure.count, 1);
  evaluate(compile({"m", scene::Mirror{}}), {}, point, closure);
  EXPECT_EQ(closure.count, 1);
  EXPECT_FALSE(closure.has_smooth);
  EXPECT_EQ(closure.pick_sum, 1);
}

}  // namespace
}  // namespace tessera::render
