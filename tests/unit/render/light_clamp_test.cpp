#include "worker/render/light_clamp.hpp"

#include <gtest/gtest.h>

#include "worker/render/record.hpp"

namespace tessera::render {
namespace {

TEST(LightClamp, IsOffUnlessAskedFor) {
  const Color bright{1e30F, 2, 3};
  for (const int depth : {0, 1, 7}) {
    EXPECT_EQ(LightClamp{}(bright, depth), bright);
    EXPECT_EQ(LightClamp::of(0, 0)(bright, depth), bright);
  }
}

TEST(LightClamp, DarkensWhatIsBrighterByDepthAndKeepsItsColour) {
  const LightClamp clamp = LightClamp::of(6, 2);
  const Color bright{24, 12, 0}, dim{3, 2, 1};
  EXPECT_EQ(clamp(bright, 0), bright) << "what the camera sees itself";
  EXPECT_EQ(clamp(bright, 1), (Color{12, 6, 0}));
  EXPECT_EQ(clamp(bright, 2), (Color{4, 2, 0}));
  EXPECT_EQ(clamp(dim, 1), dim);
  EXPECT_EQ(clamp(dim, 9), dim);
}

TEST(LightClamp, CountsForEachContributionAndNotForTheirSum) {
  SampleRecord record;
  record.clamp = LightClamp::of(2, 1);
  for (int i = 0; i < 3; ++i) record.add(gray(5), LobeShares{}, 1, 0);
  record.add(gray(5), LobeShares{}, 2, 0);
  EXPECT_EQ(record.radiance, gray(7));
}

}  // namespace
}  // namespace tessera::render
