#include "common/job/aovs.hpp"

#include <gmock/gmock.h>

#include <functional>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"

namespace tessera {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using Names = std::vector<std::string>;

std::vector<std::string> used(const Names& asked) {
  std::vector<std::string> names;
  for (const AovUse& use : aov_uses(asked)) names.push_back(use.name);
  return names;
}

std::string refusal(const std::function<void()>& act) {
  try {
    act();
    return {};
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::bad_input);
    return error.what();
  }
}

TEST(Aovs, stand_in_the_table_where_their_number_says) {
  for (std::size_t i = 0; i < aov_table().size(); ++i)
    EXPECT_EQ(static_cast<std::size_t>(aov_table()[i].aov), i) << aov_table()[i].name;
}

TEST(Aovs, of_a_job_that_names_none_are_what_denoisers_want) {
  EXPECT_THAT(used({}), ElementsAre("albedo", "N", "Z"));
}

TEST(Aovs, take_the_place_of_those_and_come_in_the_tables_order) {
  EXPECT_THAT(used({"P", "N"}), ElementsAre("N", "P"));
  EXPECT_EQ(aov_uses(Names{"Z", "albedo"}), aov_uses(Names{"albedo", "Z"}));
}

TEST(Aovs, of_light_groups_are_named_by_them) {
  const std::vector<AovUse> uses = aov_uses(Names{"light_sky", "light_key-2"});
  ASSERT_EQ(uses.size(), 2U);
  EXPECT_EQ(uses[0].aov, Aov::light);
  EXPECT_EQ(uses[0].light_group(), "key-2");
  EXPECT_EQ(uses[1].light_group(), "sky");
  EXPECT_THAT(refusal([] { (void)used({"light_a.b"}); }), HasSubstr("unknown AOV"));
  EXPECT_FALSE(is_light_group(""));
}

TEST(Aovs, add_channels_to_a_job_unless_every_picture_has_them) {
  const auto channels = [](const char* name) {
    std::vector<std::string> out;
    for (const AovChannel& channel : channels_of(aov_uses(Names{name}).front()))
      out.push_back(channel.name);
    return out;
  };
  EXPECT_THAT(channels("UV"), ElementsAre("UV.U", "UV.V"));
  EXPECT_THAT(channels("object_id"), ElementsAre("object_id"));
  EXPECT_THAT(channels("variance"), ElementsAre());
  EXPECT_THAT(channels("samples"), ElementsAre());
  const std::vector<std::string> matte = channels("CryptoMaterial");
  ASSERT_EQ(matte.size(), 33U);
  EXPECT_THAT(std::vector(matte.begin(), matte.begin() + 5),
              ElementsAre("CryptoMaterial00.R", "CryptoMaterial00.G", "CryptoMaterial00.B",
                          "CryptoMaterial00.A", "CryptoMaterial01.R"));
  EXPECT_EQ(matte[31], "CryptoMaterial07.A");
  EXPECT_EQ(matte[32], "evicted.CryptoMaterial");
}

TEST(Aovs, of_shadow_catchers_are_means_that_travel_with_every_pass) {
  const AovUse use = aov_uses(Names{std::string(shadow_catcher_aov)}).front();
  EXPECT_EQ(aov_table()[static_cast<std::size_t>(use.aov)].group, ChannelGroup::beauty);
  const std::vector<AovChannel> channels = channels_of(use);
  ASSERT_EQ(channels.size(), caught_channel_count);
  EXPECT_EQ(channels[caught_R].name, "shadow_catcher.R");
  EXPECT_EQ(channels[unshadowed_R].name, "shadow_catcher.unshadowed.R");
  EXPECT_EQ(channels[unshadowed_B].name, "shadow_catcher.unshadowed.B");
  EXPECT_EQ(channels[caught_coverage].name, "shadow_catcher.A");
  for (const AovChannel& channel : channels) EXPECT_EQ(channel.merge, Merge::mean);
}

TEST(Aovs, that_a_job_needs_stand_beside_those_that_it_asks_for) {
  EXPECT_THAT(with_aov({}, "shadow_catcher"), ElementsAre("albedo", "N", "Z", "shadow_catcher"));
  EXPECT_THAT(with_aov({"P"}, "shadow_catcher"), ElementsAre("P", "shadow_catcher"));
  EXPECT_THAT(with_aov({"shadow_catcher", "P"}, "shadow_catcher"),
              ElementsAre("shadow_catcher", "P"));
}

TEST(Aovs, that_are_unknown_or_doubled_are_refused_with_their_place) {
  EXPECT_THAT(refusal([] {
                (void)used({"Z", "albdo"});
              }),
              HasSubstr("render.aovs: unknown AOV \"albdo\"; did you mean \"albedo\"?"));
  EXPECT_THAT(refusal([] { (void)used({"Z", "Z"}); }), HasSubstr("\"Z\" stands there twice"));
  EXPECT_THAT(refusal([] { (void)used(Names(limits::aovs_max + 1, "Z")); }),
              HasSubstr("at most 64"));
}

TEST(Aovs, make_no_tile_larger_than_a_result_may_be) {
  EXPECT_EQ(refusal([] { check_aovs({}, 512); }), "");
  Names many{"direct", "indirect"};
  for (int i = 0; i < 24; ++i) many.push_back("light_" + std::to_string(i));
  EXPECT_THAT(refusal([&] { check_aovs(many, 512); }), HasSubstr("with 85 channels"));
  EXPECT_THAT(refusal([] { check_aovs({}, 2048); }), HasSubstr("tile: a tile of 2048 by 2048"));
}

}  // namespace
}  // namespace tessera
