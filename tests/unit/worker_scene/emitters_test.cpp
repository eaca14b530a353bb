#include "worker/scene/emitters.hpp"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace tessera::worker
