#include "common/assets/eviction.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <string>

namespace tessera::assets {
namespace {

using Time = std::filesystem::file_time_type;

Time at(int second) { return Time(std::chrono::seconds(second)); }

/// Named by its letter.
KeptBlob blob(char name, int used, std::uint64_t size, bool partial = false) {
  return {.used = at(used),
          .digest = digest_of(std::string(1, name)),
          .size = size,
          .partial = partial};
}

std::vector<KeptBlob> some() { return {blob('a', 30, 10), blob('b', 10, 20), blob('c', 20, 40)}; }

TEST(Eviction, nothing_goes_while_there_is_room) {
  EXPECT_TRUE(to_evict(some(), {}, {.most = 70}).empty());
  EXPECT_TRUE(to_evict({}, {}, {.most = 0}).empty());
}

TEST(Eviction, the_least_recently_used_go_first_and_only_as_many_as_must) {
  const std::vector<KeptBlob> one{blob('b', 10, 20)}, two{blob('b', 10, 20), blob('c', 20, 40)};
  EXPECT_EQ(to_evict(some(), {}, {.most = 69}), one);
  EXPECT_EQ(to_evict(some(), {}, {.most = 50}), one);
  EXPECT_EQ(to_evict(some(), {}, {.most = 49}), two);
  EXPECT_EQ(to_evict(some(), {}, {.most = 0}).size(), 3U);
}

TEST(Eviction, pinned_ones_count_and_stay) {
  const std::vector<KeptBlob> next{blob('c', 20, 40)};
  EXPECT_EQ(to_evict(some(), {digest_of("b")}, {.most = 60}), next);
  EXPECT_EQ(to_evict(some(), {digest_of("b")}, {.most = 0}).size(), 2U);
}

TEST(Eviction, what_was_just_used_stays_whatever_there_is) {
  const std::vector<KeptBlob> old{blob('b', 10, 20)};
  EXPECT_EQ(to_evict(some(), {}, {.most = 0, .young = at(15)}), old);
  EXPECT_EQ(to_evict(some(), {}, {.most = 0, .young = at(20)}).size(), 2U) << "then it is old";
}

TEST(Eviction, of_the_same_age_it_is_always_the_same_that_go) {
  const std::vector<KeptBlob> ways[]{{blob('x', 1, 5), blob('y', 1, 5), blob('x', 1, 5, true)},
                                     {blob('x', 1, 5, true), blob('y', 1, 5), blob('x', 1, 5)}};
  EXPECT_EQ(to_evict(ways[0], {}, {.most = 5}), to_evict(ways[1], {}, {.most = 5}));
}

}  // namespace
}  // namespace tessera::assets
