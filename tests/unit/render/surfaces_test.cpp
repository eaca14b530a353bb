#include "worker/render/bsdf/surfaces.hpp"

#include <gtest/gtest.h>

#include "tests/unit/render/bsdf_support.hpp"
#include "tests/unit/render/material_support.hpp"

namespace tessera::render {
namespace {

using test::closure_at, test::from_angles, test::of, test::one_texel, test::seen_from;

const Lobe* find(const Closure& closure, LobeKind kind) {
  for (int i = 0; i < closure.count; ++i) {
    if (closure.lobes[static_cast<std::size_t>(i)].kind == kind) {
      return &closure.lobes[static_cast<std::size_t>(i)];
    }
  }
  return nullptr;
}

scene::Principled all_lobes() {
  scene::Principled all;
  all.clearcoat.factor = 0.5;
  all.clearcoat_roughness.factor = 0.2;
  all.anisotropy.factor = 0.5;
  all.metallic.factor = 0.5;
  all.transmission.factor = 0.5;
  return all;
}

TEST(Surfaces, TheGreatestPrincipledSurfaceFitsAMixOfTwo) {
  scene::Principled all = all_lobes();
  for (const bool thin : {true, false}) {
    all.thin_walled = thin;
    const Closure one = closure_at(of(all), from_angles(0.7F, 1));
    EXPECT_EQ(one.count, 4);
    const scene::Material parts[] = {of(all), of(all)};
    const scene::Material mix = of(scene::Mix{0, 1, {.factor = 0.5, .texture = {}}});
    Closure both;
    evaluate(compile(mix, parts), {}, seen_from(from_angles(0.7F, 1)), both);
    EXPECT_EQ(both.count, 8);
    const Vec3 wo = from_angles(0.7F, 1), wi = from_angles(0.5F, 2);
    EXPECT_NEAR(eval(both, wo, wi).g, eval(one, wo, wi).g, 1e-5F);
    EXPECT_NEAR(pdf(both, wo, wi), pdf(one, wo, wi), 1e-5F);
  }
}

TEST(Surfaces, LayersMadeOnceAreThoseMadeAtAHit) {
  // A texture of ones makes the same surface be put together at each hit.
  const TextureTable ones = one_texel({1, 1, 1, 1});
  const auto seen = [&](const scene::Principled& surface, const Vec3& wo) {
    scene::Material material = of(surface);
    material.vertex_colors = false;
    return closure_at(material, wo, ones);
  };
  scene::Principled once = all_lobes();
  once.base_color.factor = {0.7, 0.4, 0.2};
  for (const auto& [metal, brushed] :
       {std::pair{0.0, 0.5}, {0.4, 0.5}, {1.0, 0.5}, {0.0, 0.0}, {0.4, 0.0}, {1.0, 0.0}}) {
    for (const bool thin : {true, false}) {
      once.metallic.factor = metal;
      once.anisotropy.factor = brushed;
      once.thin_walled = thin;
      scene::Principled at_hit = once;
      at_hit.base_color.texture = scene::TextureUse{};
      for (const float cosine : {0.9F, 0.2F, -0.5F}) {
        const Vec3 wo = from_angles(cosine, 1);
        const Closure a = seen(once, wo), b = seen(at_hit, wo);
        ASSERT_EQ(a.count, b.count);
        for (const Vec3& wi : {from_angles(0.6F, 2), from_angles(-0.6F, 4)}) {
          EXPECT_EQ(eval(a, wo, wi), eval(b, wo, wi)) << metal << brushed << thin << cosine;
          EXPECT_EQ(pdf(a, wo, wi), pdf(b, wo, wi)) << metal << brushed << thin << cosine;
        }
      }
    }
  }
}

TEST(Surfaces, AConductorsBouncesMadeOnceAreThoseMadeAtAHit) {
  scene::Conductor gold;
  for (const double roughness : {0.05, 0.3, 1.0}) {
    gold.roughness = roughness;
    const auto alpha = static_cast<float>(roughness) * static_cast<float>(roughness);
    const ggx::Roughness rough{alpha, alpha};
    const microfacet::Surface surface =
        microfacet::surface_of(conductor_reflectance(to_color(gold.eta), to_color(gold.k)), rough);
    for (const float cosine : {1.0F, 0.6F, 0.05F, -0.4F}) {
      const Vec3 wo = from_angles(cosine, 1);
      const Closure closure = closure_at(of(gold), wo);
      const microfacet::View view =
          microfacet::view_of(rough, {.cosine = std::min(1.0F, std::abs(wo.z))});
      ASSERT_EQ(closure.count, 1);
      EXPECT_EQ(closure.lobes[0].multiple, microfacet::lobe_of(surface, view).multiple);
      EXPECT_EQ(closure.lobes[0].multiple_share, microfacet::lobe_of(surface, view).multiple_share);
      EXPECT_EQ(closure.pick[0], max_component(microfacet::albedo(surface, view)));
    }
  }
}

TEST(Surfaces, VerticesColourWhatIsLit) {
  scene::Principled surface;
  surface.base_color.factor = {0.8, 0.8, 0.8};
  ShadingPoint point = seen_from({0, 0, 1});
  point.detail->color = {0.5F, 0.25F, 1};
  const auto diffuse = [&](const scene::Material& material) {
    Closure closure;
    evaluate(compile(material), {}, point, closure);
    const Lobe* lobe = find(closure, LobeKind::diffuse);
    return lobe == nullptr ? Color{} : lobe->weight;
  };
  scene::Material material = of(surface);
  const Color coloured = diffuse(material);
  material.vertex_colors = false;
  const Color plain = diffuse(material);
  ASSERT_GT(plain.r, 0.5F);
  EXPECT_NEAR(coloured.r, 0.5F * plain.r, 1e-6F);
  EXPECT_NEAR(coloured.g, 0.25F * plain.g, 1e-6F);
  EXPECT_NEAR(coloured.b, plain.b, 1e-6F);
}

TEST(Surfaces, WhatPassesABrushedWallOfNoRoughnessPassesStraightOn) {
  scene::Principled wall;
  wall.roughness.factor = 0;
  wall.anisotropy.factor = 0.5;
  wall.transmission.factor = 1;
  const Closure closure = closure_at(of(wall), from_angles(0.7F, 1));
  const Lobe* passing = find(closure, LobeKind::pane);
  ASSERT_NE(passing, nullptr);
  EXPECT_GT(passing->tint.g, 0.7F * 0.8F);
  EXPECT_EQ(find(closure, LobeKind::mirror), nullptr);
}

TEST(Surfaces, PrincipledSamplesFollowTheirDensity) {
  scene::Principled all = all_lobes();
  all.roughness.factor = 0.6;
  all.clearcoat_roughness.factor = 0.7;
  all.anisotropy.factor = 0.7;
  all.anisotropy_rotation = 0.4;
  all.metallic.factor = 0.3;
  for (const bool thin : {true, false}) {
    all.thin_walled = thin;
    for (const float cosine : {0.8F, -0.4F}) {
      const Vec3 wo = from_angles(cosine, 1);
      test::Chi2Case test = test::directions(closure_at(of(all), wo), wo);
      test.samples = 300'000;
      EXPECT_EQ(test::chi2_test(test), "") << thin << cosine;
    }
  }
}

TEST(Surfaces, MetalsAlbedoIsItsNormalReflectance) {
  scene::Principled metal;
  metal.base_color.factor = {0.9, 0.6, 0.2};
  metal.metallic.factor = 1;
  for (const double roughness : {0.0, 0.5}) {
    metal.roughness.factor = roughness;
    const Closure closure = closure_at(of(metal), from_angles(0.2F, 0));
    EXPECT_EQ(closure.count, 1);
    EXPECT_NEAR(albedo(closure).r, 0.9F, 1e-6F);
    EXPECT_NEAR(albedo(closure).b, 0.2F, 1e-6F);
  }
  scene::Conductor gold;
  gold.roughness = 0.3;
  EXPECT_LT(albedo(closure_at(of(gold), {0, 0, 1})).b, albedo(closure_at(of(gold), {0, 0, 1})).r);
}

TEST(Surfaces, InputsAreTheirFactorTimesTheTexture) {
  const TextureTable textures = one_texel({0.5F, 0.25F, 0.125F, 0.75F});
  scene::Principled surface;
  surface.base_color = {.factor = {1, 1, 0.5}, .texture = scene::TextureUse{}};
  surface.specular.factor = 0;
  Closure closure = closure_at(of(surface), {0, 0, 1}, textures);
  const Lobe* diffuse = find(closure, LobeKind::diffuse);
  ASSERT_NE(diffuse, nullptr);
  EXPECT_NEAR(diffuse->weight.r, 0.5F, 1e-6F);
  EXPECT_NEAR(diffuse->weight.b, 0.0625F, 1e-6F);
  EXPECT_EQ(compile(of(surface)).wants, detail_flag::uv0 | detail_flag::color);

  surface.roughness = {
      .factor = 1,
      .texture = scene::TextureUse{.texture = 0, .uv_set = 1, .to_uv = {1, 0, 0, 0, 1, 0}},
      .channel = 3};
  surface.specular.factor = 1;
  closure = closure_at(of(surface), {0, 0, 1}, textures);
  const Lobe* specular = find(closure, LobeKind::microfacet);
  ASSERT_NE(specular, nullptr);
  EXPECT_NEAR(specular->alpha_x, 0.75F * 0.75F, 1e-6F);
  EXPECT_NE(compile(of(surface)).wants & detail_flag::uv1, 0);

  surface.emission = {.factor = {1, 1, 1}, .texture = scene::TextureUse{}};
  closure = closure_at(of(surface), {0, 0, 1}, textures);
  EXPECT_NEAR(closure.emission.g, 0.25F, 1e-6F);
}

TEST(Surfaces, WhatALightSampleFindsIsWhatAPathFinds) {
  const TextureTable textures = one_texel({255, 137, 64, 191});
  scene::Principled coated;
  coated.emission = {.factor = {3, 2, 1}, .texture = scene::TextureUse{}};
  coated.clearcoat.factor = 0.8;
  scene::Material half = of(coated);
  half.opacity = {.mode = scene::Opacity::Mode::blend, .alpha = {.factor = 0.25}};
  scene::Principled unlit;
  unlit.unlit = true;
  for (const float slant : {1.0F, 0.1F, -0.5F}) {
    ShadingPoint point;
    point.wo = normalize(Vec3{1, 0, slant});
    for (const scene::Material& material :
         {of(coated), half, of(unlit), {"one side", scene::Emitter{{3, 2, 1}, false}}}) {
      const CompiledMaterial compiled = compile(material);
      const Closure found = closure_at(material, point.wo, textures);
      const Color expected = found.emission * presence(compiled, textures, point);
      EXPECT_EQ(emission(compiled, textures, point), expected);
    }
  }
  EXPECT_TRUE(compile(half).emits() && compile(half).radiance_varies);
  EXPECT_FALSE(compile(of(unlit)).emits()) << "it shines for the eye";
}

TEST(Surfaces, WhatIsCulledFromBehindShinesToTheFrontAlone) {
  scene::Material material{"lamp", scene::Emitter{{1, 1, 1}, true}};
  EXPECT_TRUE(compile(material).two_sided);
  material.back_culled = true;
  EXPECT_FALSE(compile(material).two_sided);
}

TEST(Surfaces, ACoatDimsTheLightBelowItByWhatItReflects) {
  scene::Principled surface;
  surface.emission.factor = {2, 1, 0};
  surface.clearcoat.factor = 0.5;
  surface.clearcoat_roughness.factor = 0;
  EXPECT_TRUE(compile(of(surface)).radiance_varies);
  const Closure facing = closure_at(of(surface), {0, 0, 1}, {});
  EXPECT_NEAR(facing.emission.g, 1 - 0.5F * 0.04F, 2e-3F);
  EXPECT_NEAR(facing.emission.r, 2 * facing.emission.g, 1e-6F);
  const Closure grazing = closure_at(of(surface), normalize(Vec3{1, 0, 0.05F}), {});
  EXPECT_LT(grazing.emission.g, 0.7F);
  EXPECT_GT(grazing.emission.g, 0.5F);
  surface.clearcoat.factor = 0;
  EXPECT_TRUE(compile(of(surface)).emits() && !compile(of(surface)).radiance_varies);
}

TEST(Surfaces, VerticesColourTheBaseUnlessTheyMayNot) {
  scene::Principled surface;
  surface.base_color.factor = {1, 1, 1};
  surface.unlit = true;
  scene::Material material = of(surface);
  ShadingPoint point = seen_from({0, 0, 1});
  point.detail->color = {0.5F, 0.25F, 1};
  Closure closure;
  evaluate(compile(material), {}, point, closure);
  EXPECT_EQ(closure.emission, (Color{0.5F, 0.25F, 1}));
  material.vertex_colors = false;
  evaluate(compile(material), {}, point, closure);
  EXPECT_EQ(closure.emission, gray(1));
  EXPECT_EQ(closure.count, 0);
}

TEST(Surfaces, OpacityIsAMaskOrAShare) {
  const TextureTable textures = one_texel({1, 1, 1, 0.5F});
  scene::Material material = of(scene::Diffuse{});
  const auto share = [&](const Vec3& wo = {0, 0, 1}) {
    ShadingPoint point = seen_from(wo);
    point.detail->alpha = 0.5F;
    return presence(compile(material), textures, point);
  };
  EXPECT_EQ(share(), 1);
  EXPECT_FALSE(compile(material).may_pass);
  material.opacity = {.mode = scene::Opacity::Mode::blend,
                      .alpha = {.factor = 0.8, .texture = scene::TextureUse{}, .channel = 3}};
  EXPECT_NEAR(share(), 0.8 * 0.5 * 0.5, 1e-6);
  EXPECT_TRUE(compile(material).may_pass);
  material.vertex_colors = false;
  EXPECT_NEAR(share(), 0.4, 1e-6);
  material.opacity.mode = scene::Opacity::Mode::mask;
  material.opacity.cutoff = 0.39;
  EXPECT_EQ(share(), 1);
  material.opacity.cutoff = 0.41;
  EXPECT_EQ(share(), 0);
  material = of(scene::Diffuse{});
  material.back_culled = true;
  EXPECT_EQ(share(), 1);
  EXPECT_EQ(share({0, 0, -1}), 0);
}

TEST(Surfaces, ACoatTakesItsPartFromAllBelow) {
  scene::Principled surface;
  surface.base_color.factor = {0.5, 0.5, 0.5};
  const double bare =
      test::furnace(closure_at(of(surface), from_angles(0.2F, 0)), from_angles(0.2F, 0)).mean;
  surface.clearcoat.factor = 1;
  const Closure coated = closure_at(of(surface), from_angles(0.2F, 0));
  const double with = test::furnace(coated, from_angles(0.2F, 0)).mean;
  // Schlick's .04 + .96·.8^5 of all, and the rest of what the base has.
  const double coat = 0.04 + 0.96 * std::pow(0.8, 5);
  EXPECT_NEAR(with, coat + (1 - coat) * bare, 0.01);
}

}  // namespace
}  // namespace tessera::render
