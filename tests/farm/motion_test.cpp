// A scene that moves: each frame shows its own moment, and has the same bits whoever rendered it.
#include <gtest/gtest.h>

#include "tests/farm/farm.hpp"

namespace tessera::farm_test {
namespace {

std::vector<std::string> small(const std::string& frames) {
  return {"--size", "96x54", "--samples", "4", "--tile", "32", "--frames", frames};
}

std::string windmills() { return (sources() / "scenes/windmills.json").string(); }

TEST(Motion, frames_show_their_moments_and_have_the_same_bits_whoever_rendered_them) {
  Farm many;
  many.add_worker(2);
  many.add_worker();
  const std::string range = many.submit(windmills(), small("1-37x12"));
  ASSERT_EQ(many.tessera({"wait", range}).code, 0) << many.logs();
  Farm one;
  one.add_worker();
  const std::string alone = one.submit(windmills(), small("25"));
  ASSERT_EQ(one.tessera({"wait", alone}).code, 0) << one.logs();

  const image::ExrImage moment = many.fetch_frame(range, 25);
  const auto different = image::difference(moment, one.fetch_frame(alone, 25));
  EXPECT_FALSE(different.has_value()) << different.value_or("");
  // Another seed for each frame would differ too, but not in what the camera sees first.
  const auto depths = [](const image::ExrImage& picture) {
    const auto plane = picture.plane("Z");
    return std::vector<float>(plane.begin(), plane.end());
  };
  for (const int other : {1, 13, 37})
    EXPECT_NE(depths(moment), depths(many.fetch_frame(range, other))) << other;
}

TEST(Motion, the_client_says_how_long_a_scene_moves_where_no_frames_were_asked_for) {
  Farm farm;
  const Outcome outcome = farm.tessera({"submit", windmills()});
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_NE(outcome.errors.find("--frames 1-97"), std::string::npos) << outcome.errors;
}

}  // namespace
}  // namespace tessera::farm_test
