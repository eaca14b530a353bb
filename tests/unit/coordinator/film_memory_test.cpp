#include "server/coordinator/film_memory.hpp"

#include <gmock/gmock.h>

namespace tessera::server {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

std::vector<std::size_t> dropped(const std::vector<FilmUse>& films, std::uint64_t most) {
  return films_to_drop(films, most);
}

TEST(FilmMemory, nothing_is_dropped_while_all_fit) {
  EXPECT_THAT(dropped({}, 100), IsEmpty());
  EXPECT_THAT(dropped({{60, 1, false}, {40, 2, false}}, 100), IsEmpty());
}

TEST(FilmMemory, those_used_longest_ago_go_until_three_quarters_are_left) {
  EXPECT_THAT(dropped({{30, 5, false}, {30, 1, false}, {30, 3, false}, {20, 4, false}}, 100),
              ElementsAre(1, 2));
  EXPECT_THAT(dropped({{40, 5, false}, {40, 1, false}, {30, 3, false}}, 100), ElementsAre(1));
}

TEST(FilmMemory, the_one_in_use_stays_if_it_fits_alone) {
  EXPECT_THAT(dropped({{90, 2, false}, {20, 1, false}}, 100), ElementsAre(1));
  EXPECT_THAT(dropped({{101, 1, false}}, 100), ElementsAre(0));
}

TEST(FilmMemory, what_is_held_stays_and_what_has_nothing_is_not_dropped) {
  EXPECT_THAT(dropped({{80, 1, true}, {30, 2, false}, {0, 0, false}, {10, 3, false}}, 100),
              ElementsAre(1));
  EXPECT_THAT(dropped({{80, 1, true}, {80, 2, true}}, 100), IsEmpty());
}

TEST(FilmMemory, after_a_drop_a_quarter_of_the_memory_fills_before_the_next) {
  // Two films of 60, used in turn, a tile of 1 at a time.
  std::vector<FilmUse> films{{60, 1, false}, {0, 0, false}};
  std::uint64_t clock = 2, loads = 0, drops = 0;
  for (int i = 0; i < 10'000; ++i) {
    FilmUse& film = films[static_cast<std::size_t>(i % 2)];
    film.used = ++clock;
    if (film.bytes < 60) {
      ++film.bytes;
      ++loads;
    }
    for (const std::size_t gone : films_to_drop(films, 100)) {
      films[gone].bytes = 0;
      ++drops;
    }
    ASSERT_LE(films[0].bytes + films[1].bytes, 100U);
  }
  EXPECT_GE(loads, drops * 25) << "the reading of a quarter at least stands behind each drop";
}

}  // namespace
}  // namespace tessera::server
