#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <optional>
#include <utility>

#include "tests/render/support.hpp"

/// Outputs beside the picture.
namespace tessera::render::proof {
namespace {

/// One channel's value in the middle of what a camera sees that looks at one point.
struct Seen {
  image::TileImage image;

  [[nodiscard]] float at(std::string_view channel) const {
    const int index = image.layout->index_of(channel);
    EXPECT_GE(index, 0) << channel;
    return index < 0 ? 0 : image.plane(static_cast<std::size_t>(index))[0];
  }
};

Seen look(const SceneMaker& maker, std::vector<std::string> aovs, bool follow_specular = false) {
  TaskRequest request = request_of({.side = 1, .samples = 4, .bounces = 8}, 1);
  request.settings.aovs = std::move(aovs);
  request.settings.aovs_follow_specular = follow_specular;
  tbb::task_arena arena(1);
  std::optional<RenderedTask> done = render_task(maker.build(), request, arena);
  return {std::move(done.value().image)};
}

TEST(Aov, PositionIsWhereTheFirstSurfaceIsInTheWorld) {
  SceneMaker maker;
  maker.add(maker.diffuse(0.5), scene::Quad{{90, 80, -7}, {20, 0, 0}, {0, 20, 0}});
  maker.look({100, 90, 3}, {100, 90, -7});
  const Seen seen = look(maker, {"P"});
  EXPECT_EQ(seen.image.layout->index_of("albedo.R"), -1);
  EXPECT_NEAR(seen.at("P.X"), 100, 1e-3);
  EXPECT_NEAR(seen.at("P.Y"), 90, 1e-3);
  EXPECT_NEAR(seen.at("P.Z"), -7, 1e-3);
}

/// A mirror at 45 degrees, in which the camera sees a wall of albedo 0.25 whose normal is along x.
SceneMaker mirror_before_a_wall() {
  SceneMaker maker;
  maker.add(maker.mirror(0.5), scene::Quad{{-1, -1, 1}, {2, 0, -2}, {0, 2, 0}});
  maker.add(maker.diffuse(0.25), scene::Quad{{5, -5, -5}, {0, 0, 10}, {0, 10, 0}});
  maker.look({0, 0, 5}, {0, 0, 0}, 0.001, {0, 1, 0});
  return maker;
}

TEST(Aov, AlbedoAndNormalAreTheMirrorsUnlessTheyFollowIt) {
  const SceneMaker maker = mirror_before_a_wall();
  const Seen own = look(maker, {});
  EXPECT_NEAR(own.at("albedo.R"), 0.5, 1e-6);
  EXPECT_NEAR(std::abs(own.at("N.X")), std::sqrt(0.5), 1e-5);
  const Seen followed = look(maker, {}, true);
  EXPECT_NEAR(followed.at("albedo.R"), 0.125, 1e-6);
  EXPECT_NEAR(std::abs(followed.at("N.X")), 1, 1e-5);
  EXPECT_EQ(followed.at("Z"), own.at("Z"));
  for (const std::size_t c : {image::R, image::M2_R, image::A})
    EXPECT_EQ(followed.image.plane(c)[0], own.image.plane(c)[0]);
}

TEST(Aov, ThatIsNotAskedForChangesNoBitOfThePicture) {
  const SceneMaker maker = mirror_before_a_wall();
  const Seen usual = look(maker, {}), other = look(maker, {"P"});
  for (std::size_t c = 0; c <= image::M2_B; ++c)
    EXPECT_EQ(usual.image.plane(c)[0], other.image.plane(c)[0]) << c;
}

}  // namespace
}  // namespace tessera::render::proof
