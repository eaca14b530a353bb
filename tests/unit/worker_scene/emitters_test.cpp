#include "worker/scene/emitters.hpp"

#include <gtest/gtest.h>

#include <array>

#include "worker/render/bsdf/material.hpp"

namespace tessera::worker {
namespace {

TEST(Emitters, more_lights_than_there_may_be_are_left_to_paths) {
  const std::vector<render::CompiledMaterial> materials{
      render::compile({"glow", scene::Emitter{{3, 2, 1}}})};
  scene::Shape box;
  box.geometry = scene::Box{};
  const PlacedShape placed{&box, {}};
  const MergedGroup group = merge(std::span(&placed, 1), materials, {}, {}, false);
  std::vector<render::Light> lights;
  const auto add = [&] { return add_lights(group, materials, {}, render::no_id, lights, 13); };
  EXPECT_EQ(add(), 0U);
  EXPECT_EQ(add(), 6U);
  EXPECT_EQ(add(), render::no_id);
  EXPECT_EQ(lights.size(), 12U);
}

TEST(Emitters, two_triangles_of_a_quad_are_one_where_both_shine_alike_and_evenly) {
  const auto lights_of = [](const scene::Material& material, bool quad) {
    const std::vector<render::CompiledMaterial> materials{render::compile(material)};
    scene::Mesh mesh;
    mesh.positions = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {quad ? 0.0F : 0.5F, 1, 0}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    scene::Shape shape;
    shape.geometry = mesh;
    const PlacedShape placed{&shape, {}};
    return merge(std::span(&placed, 1), materials, {}, {}, false).emitters.size();
  };
  const scene::Material even{"glow", scene::Emitter{{3, 2, 1}}};
  EXPECT_EQ(lights_of(even, true), 1U);
  EXPECT_EQ(lights_of(even, false), 2U);
  scene::Material in_part = even;
  in_part.opacity.mode = scene::Opacity::Mode::blend;
  in_part.opacity.alpha.factor = 0.5;
  EXPECT_EQ(lights_of(in_part, true), 2U);
  scene::Principled varnished;
  varnished.emission.factor = {3, 2, 1};
  varnished.clearcoat.factor = 1;
  EXPECT_EQ(lights_of({"varnished", varnished}, true), 2U);
}

TEST(Emitters, halves_of_two_materials_are_two) {
  const std::vector<render::CompiledMaterial> materials{
      render::compile({"red", scene::Emitter{{3, 0, 0}}}),
      render::compile({"blue", scene::Emitter{{0, 0, 3}}})};
  std::array<scene::Shape, 2> halves;
  for (std::uint32_t i = 0; i < 2; ++i) {
    scene::Mesh mesh;
    mesh.positions = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}};
    mesh.triangles = {i == 0 ? std::array<std::uint32_t, 3>{0, 1, 2}
                             : std::array<std::uint32_t, 3>{0, 2, 3}};
    halves[i].geometry = mesh;
    halves[i].material = i;
  }
  const std::array<PlacedShape, 2> placed{PlacedShape{halves.data(), {}},
                                          PlacedShape{&halves[1], {}}};
  const MergedGroup group = merge(placed, materials, {}, {}, false);
  ASSERT_EQ(group.group.geometries.size(), 1U);
  EXPECT_EQ(group.emitters.size(), 2U);
}

}  // namespace
}  // namespace tessera::worker
