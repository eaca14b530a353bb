#include "common/image/view.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace tessera::image {
namespace {

TEST(View, srgb_is_the_light_itself_at_the_exposure) {
  std::vector<float> rgb{0.25F, 2, -1};
  apply_view(View::srgb, 1, rgb);
  EXPECT_EQ(rgb, (std::vector<float>{0.5F, 4, -2}));
}

TEST(View, filmic_follows_the_published_curve) {
  EXPECT_NEAR(seen(View::filmic, 0.18F), 0.267, 1e-3);
  EXPECT_NEAR(seen(View::filmic, 1), 0.8038, 1e-4);
  std::vector<float> rgb{0.25F};
  apply_view(View::filmic, 2, rgb);
  EXPECT_EQ(rgb[0], seen(View::filmic, 1)) << "exposed first";
}

TEST(View, filmic_grows_from_0_to_1_whatever_comes) {
  float last = 0;
  for (float x = 1e-4F; x < 1e9F; x *= 1.1F) {
    EXPECT_GE(seen(View::filmic, x), last) << x;
    last = seen(View::filmic, x);
  }
  EXPECT_EQ(last, 1);
  for (const float bad : {0.0F, -1.0F, std::nanf("")}) EXPECT_EQ(seen(View::filmic, bad), 0);
  EXPECT_EQ(seen(View::filmic, std::numeric_limits<float>::infinity()), 1);
}

}  // namespace
}  // namespace tessera::image
