// What a film is read back from: its checkpoint, and the results that follow it.
#include <gtest/gtest.h>

#include "common/base/error.hpp"
#include "server/coordinator/frame_film.hpp"
#include "server/film/film_tile_bytes.hpp"
#include "tests/unit/session/synthetic.hpp"

namespace tessera::server {
namespace {

std::shared_ptr<const JobPlan> plan_of(std::int64_t samples) {
  JobSpec spec;
  spec.name = "film";
  spec.render.width = 16;
  spec.render.height = 8;
  spec.render.samples = samples;
  spec.tile = 8;
  return std::make_shared<const JobPlan>(spec);  // two tiles; passes end at 1, 4, 16, 64
}

ResultPlace place_of(std::uint32_t pass) { return {1, 100 * pass, 10 + pass}; }

Checkpoint checkpoint_of(std::uint32_t first, std::uint32_t second) {
  Checkpoint made;
  made.number = 7;
  if (first > 0) made.tiles.push_back({0, first, 32, 500});
  if (second > 0) made.tiles.push_back({1, second, 532, 500});
  return made;
}

class KeptFilm : public testing::Test {
 protected:
  std::shared_ptr<const JobPlan> plan = plan_of(100);  // … and at 100
  FrameFilm film{plan, 1};

  /// What the pool would do; a checkpoint's tile is as if its passes had been folded.
  [[nodiscard]] std::shared_ptr<FilmTile> fold_of(const FoldWork& work,
                                                  std::uint32_t in_checkpoint) const {
    auto tile = work.own;
    if (!tile)
      tile = std::make_shared<FilmTile>(work.before ? *work.before
                                                    : empty_film_tile(plan->grid.tile(work.tile)));
    for (std::uint32_t pass = 0; work.checkpoint && pass < in_checkpoint; ++pass)
      fold(*tile, synthetic_tile(*plan, {1, work.tile, pass}));
    for (const auto& pass : work.passes) {
      EXPECT_EQ(pass.pass, tile->passes);
      fold(*tile, synthetic_tile(*plan, {1, work.tile, pass.pass}));
    }
    return tile;
  }
  void fold_in(std::uint32_t tile, std::uint32_t pass, std::uint32_t in_checkpoint = 0) {
    film.durable(tile, pass, place_of(pass), nullptr);
    while (const auto work = film.next(tile)) film.done(*work, fold_of(*work, in_checkpoint));
  }
  void expect_straight(std::uint32_t tile, std::uint32_t passes) {
    Film straight(plan->grid);
    for (std::uint32_t pass = 0; pass < passes; ++pass)
      straight.fold(tile, synthetic_tile(*plan, {1, tile, pass}));
    EXPECT_EQ(film.snapshot().tiles[tile]->sums, straight.snapshot().tiles[tile]->sums);
  }
};

TEST_F(KeptFilm, DroppedTileIsReadBackFromAllItsResultsAndGoesOn) {
  fold_in(0, 0);
  fold_in(0, 1);
  EXPECT_EQ(film.memory(), film_bytes(64, *image::default_layout()));
  const std::uint64_t version = film.version();
  film.drop();
  EXPECT_EQ(film.memory(), 0U);
  EXPECT_FALSE(film.loaded());
  EXPECT_FALSE(film.next(0)) << "nobody needs it";
  EXPECT_EQ(film.passes(0), 2U);
  EXPECT_EQ(film.version(), version);
  fold_in(0, 2);
  EXPECT_EQ(film.passes(0), 3U);
  EXPECT_EQ(film.memory(), film_bytes(64, *image::default_layout()));
  expect_straight(0, 3);
}

TEST_F(KeptFilm, DroppedTileThatAPictureNeedsIsAsNewAsItWas) {
  fold_in(0, 0);
  fold_in(1, 0);
  const std::vector<std::uint64_t> versions = film.snapshot().versions;
  film.drop();
  film.demand();
  for (const std::uint32_t tile : {0U, 1U}) {
    const auto work = film.next(tile);
    ASSERT_TRUE(work);
    EXPECT_TRUE(work->loads);
    EXPECT_FALSE(film.done(*work, fold_of(*work, 0)));
  }
  ASSERT_TRUE(film.loaded());
  EXPECT_EQ(film.snapshot().versions, versions) << "nobody is sent what he has";
}

TEST_F(KeptFilm, TileThatIsBeingFoldedIntoStays) {
  fold_in(0, 0);
  fold_in(1, 0);
  film.durable(0, 1, place_of(1), nullptr);
  const auto work = film.next(0);
  ASSERT_TRUE(work && work->own);
  film.drop();
  EXPECT_EQ(film.memory(), film_bytes(64, *image::default_layout()));
  film.done(*work, fold_of(*work, 0));
  fold_in(1, 1);  // brings the other back
  expect_straight(0, 2);
}

TEST_F(KeptFilm, CheckpointTakesThePlaceOfWhatItHolds) {
  for (std::uint32_t pass = 0; pass < 3; ++pass) fold_in(0, pass);
  fold_in(1, 0);
  EXPECT_EQ(film.journal_bytes(), 10U + 11 + 12 + 10);
  film.checkpointed(checkpoint_of(2, 1));
  EXPECT_EQ(film.journal_bytes(), 12U);
  film.drop();
  film.demand();
  const auto first = film.next(0);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->checkpoint, (CheckpointPlace{7, 32, 500}));
  ASSERT_EQ(first->passes.size(), 1U);
  EXPECT_EQ(first->passes[0].pass, 2U);
  EXPECT_EQ(first->passes[0].place, place_of(2));
  film.done(*first, fold_of(*first, 2));
  const auto second = film.next(1);
  ASSERT_TRUE(second);
  EXPECT_TRUE(second->passes.empty());
  film.done(*second, fold_of(*second, 1));
  expect_straight(0, 3);
}

TEST_F(KeptFilm, AfterAStartCheckpointAndResultsCountTogether) {
  film.restore_checkpoint(0, 2, {7, 32, 500});
  film.restore(0, 1, place_of(1));  // a second result of a pass that is in the checkpoint
  film.restore(0, 2, place_of(2));
  film.restore(0, 4, place_of(4));
  film.restored();
  EXPECT_EQ(film.passes(0), 3U);
  EXPECT_EQ(film.version(), 3U);
  EXPECT_EQ(film.journal_bytes(), 12U);
  fold_in(0, 3, 2);
  EXPECT_EQ(film.passes(0), 5U);
  film.demand();
  expect_straight(0, 5);
}

TEST_F(KeptFilm, OnceItsLastPassIsNoRegularOneNoCheckpointIsWorthIts) {
  for (std::uint32_t pass = 0; pass < 4; ++pass) fold_in(0, pass);
  EXPECT_GT(film.journal_bytes(), 0U);
  fold_in(0, 4);
  EXPECT_EQ(film.journal_bytes(), 0U);
}

TEST_F(KeptFilm, VersionGoesOnFromThatOfEarlierPlans) {
  FrameFilm later(plan, 1, 50);
  EXPECT_EQ(later.version(), 50U);
  later.restore_checkpoint(0, 2, {7, 32, 500});
  later.restored();
  EXPECT_EQ(later.version(), 52U);
}

TEST(FilmTileBytes, GiveEveryBitBack) {
  const auto plan = plan_of(64);
  for (const std::uint32_t passes : {0U, 1U, 4U}) {
    FilmTile tile = empty_film_tile(plan->grid.tile(1));
    for (std::uint32_t pass = 0; pass < passes; ++pass)
      fold(tile, synthetic_tile(*plan, {1, 1, pass}));
    const auto bytes = bytes_of(tile);
    EXPECT_LT(bytes.size(), film_bytes(64, *image::default_layout()) + 128)
        << "and are no more than the sums";
    const FilmTile back = film_tile_from(bytes, tile.window, image::default_layout());
    EXPECT_EQ(back.sums, tile.sums);
    EXPECT_EQ(back.samples, tile.samples);
    EXPECT_EQ(back.passes, passes);
  }
}

TEST(FilmTileBytes, ThatAreNotTheTileAreRefused) {
  const auto plan = plan_of(64);
  const FilmTile tile = empty_film_tile(plan->grid.tile(0));
  auto bytes = bytes_of(tile);
  EXPECT_THROW(film_tile_from(bytes, plan->grid.tile(1), image::default_layout()), Error);
  for (const std::size_t size : {std::size_t{0}, std::size_t{3}, bytes.size() - 1})
    EXPECT_THROW(film_tile_from(std::span(bytes).first(size), tile.window, image::default_layout()),
                 Error)
        << size;
  bytes.push_back({});
  EXPECT_THROW(film_tile_from(bytes, tile.window, image::default_layout()), Error);
}

}  // namespace
}  // namespace tessera::server
