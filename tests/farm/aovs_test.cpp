// What a job asks for beside the picture, on real processes: the channels of its file, their sums
// and their bits.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/farm/farm.hpp"
#include "tests/farm/reference.hpp"

namespace tessera::farm_test {
namespace {

constexpr const char* all_aovs =
    "albedo,Z,P,direct,indirect,emission,diffuse,specular,transmission,light_default";

/// 40 samples: more than AOVs of the first surface travel with.
image::ExrImage with_aovs(Farm& farm, int tile, bool disturbed) {
  std::vector<std::string> arguments = arguments_of({.samples = 40, .tile = tile});
  arguments.insert(arguments.end(), {"--aovs", all_aovs});
  const std::string id = farm.submit(scene_path(), arguments);
  if (disturbed) {
    EXPECT_TRUE(farm.wait_for_progress(id, 0.3)) << farm.logs();
    farm.kill_and_restart_server();
  }
  return farm.finish(id);
}

TEST(Aovs, have_the_same_bits_whatever_the_tiles_and_a_killed_coordinator) {
  Farm one, two;
  one.add_worker();
  two.add_worker();
  two.add_worker();
  const image::ExrImage reference = with_aovs(one, 64, false);
  EXPECT_TRUE(reference.has("P.X"));
  EXPECT_TRUE(reference.has("light_default.B"));
  EXPECT_FALSE(reference.has("N.X"));
  const auto found = image::difference(reference, with_aovs(two, 23, true));
  EXPECT_FALSE(found.has_value()) << *found;
}

TEST(Aovs, that_make_up_the_picture_sum_to_it_over_all_samples) {
  Farm farm;
  farm.add_worker(2);
  const image::ExrImage picture = with_aovs(farm, 64, false);
  const std::vector<std::vector<std::string>> sums{
      {"direct", "indirect", "emission"},
      {"emission", "diffuse", "specular", "transmission"},
      {"light_default"}};
  for (const auto& parts : sums)
    for (const char* component : {"R", "G", "B"}) {
      const auto whole = picture.plane(component);
      for (std::size_t i = 0; i < whole.size(); ++i) {
        double sum = 0;
        for (const std::string& part : parts) sum += picture.plane(part + '.' + component)[i];
        ASSERT_NEAR(sum, whole[i], 1e-5 * std::abs(whole[i]) + 1e-12) << parts[0] << component << i;
      }
    }
}

TEST(Aovs, that_are_unknown_are_refused_before_anything_is_queued) {
  const Farm farm;
  const Outcome out = farm.tessera({"submit", scene_path(), "--aovs", "Z,albdo"});
  EXPECT_EQ(out.code, 2);
  EXPECT_NE(out.errors.find("--aovs: unknown AOV \"albdo\"; did you mean \"albedo\"?"),
            std::string::npos)
      << out.errors;
}

}  // namespace
}  // namespace tessera::farm_test
