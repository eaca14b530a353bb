#include "worker/agent/built_scenes.hpp"

#include <gtest/gtest.h>

#include "tests/unit/agent/fakes.hpp"

namespace tessera::agent {
namespace {

std::shared_ptr<const PreparedScene> some_scene(bool coordinates) {
  return std::make_shared<const FakeScene>(coordinates);
}

RenderSettings asking_for(const char* aov) {
  RenderSettings out;
  out.aovs = {aov};
  return out;
}

TEST(BuiltScenes, are_found_by_those_whom_they_serve) {
  const Digest bundle = digest_of("bundle");
  const RenderSettings plain = asking_for("N"), with_uv = asking_for("UV");
  BuiltScenes scenes;
  EXPECT_EQ(scenes.find(bundle, plain), nullptr);
  const auto small = some_scene(false);
  scenes.add(bundle, small);
  EXPECT_EQ(scenes.find(bundle, plain), small);
  EXPECT_EQ(scenes.find(digest_of("other"), plain), nullptr);
  EXPECT_EQ(scenes.find(bundle, with_uv), nullptr) << "it keeps no coordinates";
  const auto large = some_scene(true);
  scenes.add(bundle, large);
  EXPECT_EQ(scenes.find(bundle, with_uv), large);
  EXPECT_EQ(scenes.find(bundle, plain), small);
}

TEST(BuiltScenes, that_keep_more_serve_those_that_look_at_less) {
  BuiltScenes scenes;
  const auto large = some_scene(true);
  scenes.add(Digest{}, large);
  EXPECT_EQ(scenes.find(Digest{}, asking_for("N")), large);
}

TEST(BuiltScenes, that_nobody_has_are_forgotten) {
  BuiltScenes scenes;
  auto scene = some_scene(true);
  const std::weak_ptr<const PreparedScene> watch = scene;
  scenes.add(Digest{}, scene);
  scene.reset();
  EXPECT_TRUE(watch.expired());
  EXPECT_EQ(scenes.find(Digest{}, {}), nullptr);
}

}  // namespace
}  // namespace tessera::agent
