#include "server/coordinator/frame_film.hpp"

#include <gtest/gtest.h>

#include "tests/unit/session/synthetic.hpp"

namespace tessera::server {
namespace {

std::shared_ptr<const JobPlan> plan_of(int width, int tile, std::int64_t samples) {
  JobSpec spec;
  spec.name = "film";
  spec.render.width = width;
  spec.render.height = tile;
  spec.render.samples = samples;
  spec.tile = tile;
  return std::make_shared<const JobPlan>(spec);
}

ResultPlace place_of(std::uint32_t pass) { return {1, 100 * pass, 10}; }

std::shared_ptr<const DecodedTile> decoded(const JobPlan& plan, std::uint32_t tile,
                                           std::uint32_t pass) {
  const TaskId task{1, tile, pass};
  return std::make_shared<const DecodedTile>(
      decode(std::make_shared<const std::vector<std::byte>>(
                 image::encode_tile(synthetic_tile(plan, task))),
             expectation_of(plan, task)));
}

/// What the pool would do.
std::shared_ptr<FilmTile> fold_of(const JobPlan& plan, const FoldWork& work) {
  auto tile = work.own;
  if (!tile)
    tile = std::make_shared<FilmTile>(work.before ? *work.before
                                                  : empty_film_tile(plan.grid.tile(work.tile)));
  for (const auto& pass : work.passes) fold(*tile, synthetic_tile(plan, {1, work.tile, pass.pass}));
  return tile;
}

std::vector<std::uint32_t> passes_of(const FoldWork& work) {
  std::vector<std::uint32_t> passes;
  for (const auto& pass : work.passes) passes.push_back(pass.pass);
  return passes;
}

using Passes = std::vector<std::uint32_t>;

class FrameFilmTest : public testing::Test {
 protected:
  std::shared_ptr<const JobPlan> plan =
      plan_of(16, 8, 64);  // two tiles, passes end at 1, 4, 16, 64
  FrameFilm film{plan, 1};
};

TEST_F(FrameFilmTest, PassInOrderIsFoldedFromMemory) {
  film.durable(0, 0, place_of(0), decoded(*plan, 0, 0));
  const auto work = film.next(0);
  ASSERT_TRUE(work);
  EXPECT_EQ(passes_of(*work), Passes{0});
  EXPECT_TRUE(work->passes[0].tile);
  EXPECT_TRUE(film.done(*work, fold_of(*plan, *work)));
  EXPECT_EQ(film.passes(0), 1U);
  EXPECT_EQ(film.version(), 1U);
}

TEST_F(FrameFilmTest, TileThatNobodyElseHoldsIsFoldedIntoWithoutACopy) {
  film.durable(0, 0, place_of(0), decoded(*plan, 0, 0));
  auto work = film.next(0);
  ASSERT_TRUE(work);
  const auto sums = fold_of(*plan, *work);
  film.done(*work, sums);
  film.durable(0, 1, place_of(1), decoded(*plan, 0, 1));
  work = film.next(0);
  ASSERT_TRUE(work);
  EXPECT_EQ(work->own, sums);
  EXPECT_FALSE(film.loaded()) << "a snapshot would see sums that change";
  film.done(*work, fold_of(*plan, *work));
  EXPECT_TRUE(film.loaded());
}

TEST_F(FrameFilmTest, SnapshotThatIsWantedHasTilesCopiedUntilItIsTaken) {
  film.durable(0, 0, place_of(0), decoded(*plan, 0, 0));
  auto work = film.next(0);
  ASSERT_TRUE(work);
  film.done(*work, fold_of(*plan, *work));
  film.demand();
  film.durable(0, 1, place_of(1), decoded(*plan, 0, 1));
  work = film.next(0);
  ASSERT_TRUE(work);
  EXPECT_FALSE(work->own);
  ASSERT_TRUE(work->before);
  EXPECT_TRUE(film.loaded());
  const FilmSnapshot first = film.snapshot();
  film.done(*work, fold_of(*plan, *work));
  EXPECT_EQ(first.tiles[0]->passes, 1U);
  const FilmSnapshot second = film.snapshot();
  film.durable(0, 2, place_of(2), decoded(*plan, 0, 2));
  work = film.next(0);
  ASSERT_TRUE(work);
  EXPECT_FALSE(work->own) << "the second snapshot holds it";
  film.done(*work, fold_of(*plan, *work));
  EXPECT_EQ(second.tiles[0]->passes, 2U);
  film.durable(0, 3, place_of(3), decoded(*plan, 0, 3));
  work = film.next(0);
  ASSERT_TRUE(work);
  EXPECT_TRUE(work->own);
  film.done(*work, fold_of(*plan, *work));
  EXPECT_EQ(film.snapshot().tiles[0]->sums, straight_fold(*plan, 1).tiles[0]->sums);
}

TEST_F(FrameFilmTest, EarlyPassKeepsItsPlaceAndNotItsPixels) {
  film.durable(0, 2, place_of(2), decoded(*plan, 0, 2));
  EXPECT_FALSE(film.next(0));
  film.durable(0, 0, place_of(0), decoded(*plan, 0, 0));
  auto work = film.next(0);
  ASSERT_TRUE(work);
  EXPECT_EQ(passes_of(*work), Passes{0});
  EXPECT_FALSE(film.next(0)) << "one fold of a tile at a time";
  film.done(*work, fold_of(*plan, *work));
  EXPECT_FALSE(film.next(0));
  film.durable(0, 1, place_of(1), decoded(*plan, 0, 1));
  work = film.next(0);
  ASSERT_TRUE(work);
  EXPECT_EQ(passes_of(*work), (Passes{1, 2}));
  EXPECT_TRUE(work->passes[0].tile);
  EXPECT_FALSE(work->passes[1].tile);
  EXPECT_EQ(work->passes[1].place, place_of(2));
  film.done(*work, fold_of(*plan, *work));
  EXPECT_EQ(film.passes(0), 3U);
}

TEST_F(FrameFilmTest, PassThatFollowsTheOneBeingFoldedKeepsItsPixels) {
  film.durable(0, 0, place_of(0), decoded(*plan, 0, 0));
  const auto first = film.next(0);
  film.durable(0, 1, place_of(1), decoded(*plan, 0, 1));
  film.done(*first, fold_of(*plan, *first));
  const auto second = film.next(0);
  ASSERT_TRUE(second);
  EXPECT_TRUE(second->passes[0].tile);
}

TEST_F(FrameFilmTest, SecondResultOfAPassChangesNothing) {
  film.durable(0, 0, place_of(0), decoded(*plan, 0, 0));
  film.durable(0, 0, place_of(7), decoded(*plan, 0, 0));
  const auto work = film.next(0);
  EXPECT_EQ(work->passes.size(), 1U);
  EXPECT_EQ(work->passes[0].place, place_of(0));
  film.durable(0, 0, place_of(8), decoded(*plan, 0, 0));  // while it is being folded
  film.done(*work, fold_of(*plan, *work));
  film.durable(0, 0, place_of(9), decoded(*plan, 0, 0));
  EXPECT_FALSE(film.next(0));
}

TEST_F(FrameFilmTest, TilesAreFoldedIndependently) {
  film.durable(0, 0, place_of(0), decoded(*plan, 0, 0));
  film.durable(1, 0, place_of(1), decoded(*plan, 1, 0));
  const auto one = film.next(0);
  const auto two = film.next(1);
  ASSERT_TRUE(one && two);
  film.done(*two, fold_of(*plan, *two));
  EXPECT_EQ(film.passes(0), 0U);
  EXPECT_EQ(film.passes(1), 1U);
}

class RestoredFilm : public FrameFilmTest {
 protected:
  RestoredFilm() {
    film.restore(0, 0, place_of(0));
    film.restore(0, 1, place_of(1));
    film.restore(0, 3, place_of(3));
    film.restore(1, 1, place_of(1));
    film.restored();
  }
};

TEST_F(RestoredFilm, CountsAsFoldedWhatIsDurableInOrder) {
  EXPECT_EQ(film.passes(0), 2U);
  EXPECT_EQ(film.passes(1), 0U);
  EXPECT_EQ(film.version(), 2U);
  EXPECT_FALSE(film.loaded());
}

TEST_F(RestoredFilm, IsReadBackOnlyWhenNeeded) {
  EXPECT_FALSE(film.next(0));
  film.demand();
  const auto work = film.next(0);
  ASSERT_TRUE(work);
  EXPECT_TRUE(work->loads);
  EXPECT_EQ(passes_of(*work), (Passes{0, 1}));
  EXPECT_FALSE(film.done(*work, fold_of(*plan, *work)));
  EXPECT_TRUE(film.loaded());
  EXPECT_EQ(film.version(), 2U) << "what is read back is nothing new";
  EXPECT_FALSE(film.next(0));
}

TEST_F(RestoredFilm, NewPassHasItsTileReadBackFirst) {
  film.durable(0, 2, place_of(2), decoded(*plan, 0, 2));
  const auto load = film.next(0);
  ASSERT_TRUE(load);
  EXPECT_TRUE(load->loads);
  film.durable(0, 1, place_of(9), decoded(*plan, 0, 1));  // known already
  film.done(*load, fold_of(*plan, *load));
  const auto work = film.next(0);
  ASSERT_TRUE(work);
  EXPECT_EQ(passes_of(*work), (Passes{2, 3}));
  EXPECT_TRUE(film.done(*work, fold_of(*plan, *work)));
  EXPECT_EQ(film.passes(0), 4U);
  const FilmSnapshot snapshot = film.snapshot();
  const FilmSnapshot straight = straight_fold(*plan, 1);
  EXPECT_EQ(snapshot.tiles[0]->sums, straight.tiles[0]->sums);
  EXPECT_GT(snapshot.version, 2U);
}

TEST_F(RestoredFilm, EarlierVersionsAreNeverLarger) {
  // A film that folded the same passes without a restart told at most one version a pass.
  FrameFilm straight(plan, 1);
  for (const std::uint32_t pass : {0U, 1U}) {
    straight.durable(0, pass, place_of(pass), decoded(*plan, 0, pass));
    const auto work = straight.next(0);
    straight.done(*work, fold_of(*plan, *work));
  }
  EXPECT_LE(straight.version(), film.version());
}

}  // namespace
}  // namespace tessera::server
