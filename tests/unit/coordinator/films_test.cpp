#include "server/coordinator/films.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <future>

#include "server/film/film_tile_bytes.hpp"
#include "tests/unit/session/synthetic.hpp"

namespace tessera::server {
namespace {

constexpr std::int32_t frames = 8;
constexpr std::uint32_t tiles = 4;
constexpr std::uint32_t passes = 4;

std::shared_ptr<const JobPlan> plan_of_frames() {
  JobSpec spec;
  spec.name = "film";
  spec.bundle = digest_of("scene");
  spec.render.width = 8 * static_cast<int>(tiles);
  spec.render.height = 8;
  spec.render.samples = 64;  // passes end at 1, 4, 16, 64
  spec.tile = 8;
  spec.frames = {1, frames, 1};
  return std::make_shared<const JobPlan>(spec);
}

/// Films in memory for two of them. The pool, of one thread, and the I/O thread's part run in turn,
/// so that one may fall as far behind the other as it can.
class FilmsTest : public testing::Test {
 protected:
  ~FilmsTest() override { pool.join(); }

  static ResultPlace place_of(const TaskId& task) {
    return {static_cast<std::uint64_t>(task.frame), task.tile, task.pass};
  }
  [[nodiscard]] DecodedTile tile_of(const TaskId& task) const {
    return decode(std::make_shared<const std::vector<std::byte>>(
                      image::encode_tile(synthetic_tile(*plan, task))),
                  expectation_of(*plan, task));
  }
  /// The pass of every tile of the frame is durable.
  void arrives(std::int32_t frame, std::uint32_t pass) {
    for (std::uint32_t tile = 0; tile < tiles; ++tile) {
      const TaskId task{frame, tile, pass};
      films.durable(1, plan, 0, task, place_of(task), std::make_shared<DecodedTile>(tile_of(task)));
    }
    films.flush();
  }
  void all_arrive(std::uint32_t pass) {
    for (std::int32_t frame = 1; frame <= frames; ++frame) arrives(frame, pass);
  }
  /// The pool does all that it was given, then it stands while what it did is told.
  void take_turns() {
    std::promise<void> reached, go_on;
    boost::asio::post(pool, [&] { reached.set_value(); });
    reached.get_future().wait();
    boost::asio::post(pool, [gate = go_on.get_future().share()] { gate.wait(); });
    while (io.poll() > 0) io.restart();
    io.restart();
    go_on.set_value();
  }
  void settle() {
    bool ended = false;
    boost::asio::co_spawn(io, crew.ended(), [&](const std::exception_ptr&) { ended = true; });
    for (int turn = 0; !ended && turn < 10'000; ++turn) take_turns();
    ASSERT_TRUE(ended) << "folding does not end";
  }
  void expect_all_folded(std::uint32_t count) {
    for (std::int32_t frame = 1; frame <= frames; ++frame)
      EXPECT_EQ(films.find(1, frame)->version(), tiles * count) << "frame " << frame;
  }

  const std::shared_ptr<const JobPlan> plan = plan_of_frames();
  const std::uint64_t film = film_bytes(plan->grid.window().pixels(), *image::default_layout());
  const std::uint64_t memory = 2 * film;
  boost::asio::io_context io{1};
  boost::asio::thread_pool pool{1};
  Crew crew{io.get_executor()};
  std::uint64_t most = 0;
  std::size_t read = 0;
  Films films{io.get_executor(),
              pool,
              1,
              crew,
              memory,
              {[this](const ResultPlace& place, const image::TileExpectation&) {
                 ++read;
                 return tile_of({static_cast<std::int32_t>(place.segment),
                                 static_cast<std::uint32_t>(place.offset),
                                 static_cast<std::uint32_t>(place.length)});
               },
               {}},
              {[](JobId, std::int32_t, std::uint32_t, std::uint32_t) {},
               [](JobId, const std::string& reason) { ADD_FAILURE() << reason; },
               [this] { most = std::max(most, films.memory()); }}};
};

TEST_F(FilmsTest, TakeNoMoreThanTheirMemoryAndWhatIsFoldedHoweverFarThePoolIsBehind) {
  for (std::uint32_t pass = 0; pass < passes; ++pass) {
    all_arrive(pass);
    settle();
    expect_all_folded(pass + 1);
  }
  EXPECT_GT(read, 0U) << "they were never dropped";
  EXPECT_GT(most, memory / 2);
  EXPECT_LE(most, memory + memory / 4);
}

TEST_F(FilmsTest, SnapshotsOfFilmsThatWereDroppedAreWholeThoughTheyAreReadBackPieceByPiece) {
  for (std::uint32_t pass = 0; pass < passes; ++pass) {
    all_arrive(pass);
    settle();
  }
  ASSERT_FALSE(films.find(1, 1)->loaded());
  int taken = 0;
  const auto take = [&](std::int32_t frame) -> boost::asio::awaitable<void> {
    const FilmSnapshot snapshot = co_await films.snapshot(1, frame);
    const FilmSnapshot expected = straight_fold(*plan, frame);
    for (std::uint32_t tile = 0; tile < tiles; ++tile)
      EXPECT_EQ(snapshot.tiles.at(tile)->sums, expected.tiles.at(tile)->sums);
    ++taken;
  };
  // Two of one frame, as a person and a checkpoint may want it at once.
  for (const std::int32_t frame : {1, 1, 2}) crew.start("a snapshot", take(frame));
  settle();
  EXPECT_EQ(taken, 3);
}

}  // namespace
}  // namespace tessera::server
