#include "common/job/pass_plan.hpp"

#include <gmock/gmock.h>

namespace tessera {
namespace {

using testing::ElementsAre;

std::vector<std::int64_t> ends(std::int64_t samples, int most) {
  const PassPlan plan(samples, most);
  std::vector<std::int64_t> out;
  for (std::uint32_t i = 0; i < plan.count(); ++i) out.push_back(plan.pass(i).end());
  return out;
}

TEST(PassPlan, ends_grow_fourfold_to_256_and_then_by_the_most) {
  EXPECT_THAT(ends(1024, 256), ElementsAre(1, 4, 16, 64, 256, 512, 768, 1024));
  EXPECT_THAT(ends(2048, 1024), ElementsAre(1, 4, 16, 64, 256, 1280, 2048));
}

TEST(PassPlan, ends_with_the_samples_asked_for) {
  EXPECT_THAT(ends(100, 256), ElementsAre(1, 4, 16, 64, 100));
  EXPECT_THAT(ends(1, 256), ElementsAre(1));
  EXPECT_THAT(ends(2, 256), ElementsAre(1, 2));
  EXPECT_THAT(ends(256, 256), ElementsAre(1, 4, 16, 64, 256));
  EXPECT_THAT(ends(257, 256), ElementsAre(1, 4, 16, 64, 256, 257));
}

TEST(PassPlan, no_pass_is_larger_than_the_most) {
  EXPECT_THAT(ends(50, 16), ElementsAre(1, 4, 16, 32, 48, 50));
  EXPECT_THAT(ends(6, 2), ElementsAre(1, 3, 5, 6));
  EXPECT_THAT(ends(3, 1), ElementsAre(1, 2, 3));
  for (const int most : {1, 2, 3, 5, 12, 16, 47, 48, 100, 192, 256, 1024})
    for (const std::int64_t samples : {1, 7, 64, 100, 255, 1000, 5000}) {
      const PassPlan plan(samples, most);
      std::int64_t next = 0;
      for (std::uint32_t i = 0; i < plan.count(); ++i) {
        ASSERT_EQ(plan.pass(i).first, next);
        ASSERT_GE(plan.pass(i).count, 1);
        ASSERT_LE(plan.pass(i).count, most);
        next = plan.pass(i).end();
      }
      ASSERT_EQ(next, samples);
      ASSERT_EQ(plan.samples(), samples);
    }
}

TEST(PassPlan, for_more_samples_changes_in_its_last_pass_alone) {
  for (std::int64_t samples = 1; samples < 700; ++samples) {
    const PassPlan less(samples, 256), more(samples + 300, 256);
    for (std::uint32_t i = 0; i + 1 < less.count(); ++i)
      ASSERT_EQ(less.pass(i), more.pass(i)) << samples;
  }
}

TEST(PassPlan, counts_the_passes_that_every_plan_of_more_samples_has_as_well) {
  EXPECT_EQ(PassPlan(1, 256).regular(), 1U);
  EXPECT_EQ(PassPlan(20, 256).regular(), 3U);
  EXPECT_EQ(PassPlan(64, 256).regular(), 4U);
  EXPECT_EQ(PassPlan(100, 256).regular(), 4U);
  EXPECT_EQ(PassPlan(256, 256).regular(), 5U);
  EXPECT_EQ(PassPlan(300, 256).regular(), 5U);
  EXPECT_EQ(PassPlan(50, 16).regular(), 5U);
  for (std::int64_t samples = 1; samples < 600; ++samples) {
    const PassPlan less(samples, 64), more(samples + 1, 64);
    for (std::uint32_t i = 0; i < less.regular(); ++i) ASSERT_EQ(less.pass(i), more.pass(i));
    if (less.regular() == less.count()) continue;
    ASSERT_NE(less.pass(less.regular()), more.pass(less.regular())) << samples;
  }
}

TEST(PassPlan, brings_AOVs_with_the_passes_that_end_in_time_and_always_with_the_first) {
  const PassPlan plan(100, 256);
  EXPECT_TRUE(plan.has_aovs(0, 1));
  EXPECT_FALSE(plan.has_aovs(1, 1));
  EXPECT_TRUE(plan.has_aovs(2, 16));
  EXPECT_FALSE(plan.has_aovs(3, 16));
  EXPECT_FALSE(plan.has_aovs(2, 15));
  EXPECT_TRUE(plan.has_aovs(4, 100));
}

TEST(PassPlan, without_samples_is_empty) {
  const PassPlan plan;
  EXPECT_EQ(plan.count(), 0U);
  EXPECT_EQ(plan.samples(), 0);
}

}  // namespace
}  // namespace tessera
