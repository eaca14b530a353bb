#include "server/schedule/frame_tasks.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <set>
#include <vector>

namespace tessera::server {
namespace {

using State = FrameTasks::State;

/// The same rules, by walking through everything.
struct Plain {
  std::shared_ptr<const TileRanks> ranks;
  std::uint32_t tiles, passes, ahead;
  std::set<FrameTask> taken{}, closed{};
  std::vector<std::uint32_t> folded = std::vector<std::uint32_t>(tiles);
  std::uint32_t offered = passes;
  std::optional<FocusTiles> focus{};

  [[nodiscard]] State state(const FrameTask& task) const {
    if (closed.contains(task)) return State::closed;
    return taken.contains(task) ? State::taken : State::open;
  }
  [[nodiscard]] std::optional<FrameTask> first() const {
    if (const auto task = first(0, 1, true)) return task;
    if (const auto task = first(0, 1, false)) return task;
    if (const auto task = first(1, offered, true)) return task;
    return first(1, offered, false);
  }
  [[nodiscard]] std::optional<FrameTask> first(std::uint32_t from, std::uint32_t to,
                                               bool in_focus) const {
    for (std::uint32_t pass = from; pass < std::min(to, offered); ++pass) {
      for (std::uint32_t rank = 0; rank < tiles; ++rank) {
        const std::uint32_t tile = ranks->tile(rank);
        if ((focus && focus->contains(tile)) != in_focus) continue;
        if (pass < folded[tile] + ahead && state({pass, tile}) == State::open)
          return FrameTask{pass, tile};
      }
    }
    return std::nullopt;
  }
};

TEST(FrameTasks, DoWhatAWalkThroughAllTasksWouldDo) {
  for (std::uint32_t seed = 0; seed < 60; ++seed) {
    std::mt19937 random(seed);
    const auto below = [&](std::uint32_t end) {
      return static_cast<std::uint32_t>(random() % end);
    };
    const TileGrid grid(static_cast<int>(1 + below(6)), static_cast<int>(1 + below(6)), 1);
    const auto ranks = std::make_shared<const TileRanks>(grid, static_cast<TileOrder>(below(3)));
    Plain plain{ranks, grid.count(), 1 + below(40), 1 + below(5)};
    FrameTasks tasks(ranks, plain.passes, plain.ahead);
    const auto offer = [&](std::uint32_t passes) {
      plain.offered = passes;
      tasks.offer_passes(passes);
    };
    if (seed % 3 == 0) offer(1);
    for (int step = 0; step < 3000 && !tasks.finished(); ++step) {
      const auto next = tasks.peek();
      ASSERT_EQ(next, plain.first()) << "seed " << seed << " step " << step;
      if (!next && plain.offered < plain.passes) offer(plain.offered + 1);
      if (below(20) == 0) {
        plain.focus.reset();
        if (below(3) != 0) {
          const auto x = static_cast<int>(below(static_cast<std::uint32_t>(grid.columns())));
          const auto y = static_cast<int>(below(static_cast<std::uint32_t>(grid.rows())));
          plain.focus.emplace(grid, Rect{x, y, grid.columns() - x, grid.rows() - y});
        }
        tasks.set_focus(plain.focus);
        ASSERT_EQ(tasks.peek(), plain.first()) << "seed " << seed << " step " << step;
        continue;
      }
      const std::uint32_t choice = below(10);
      if (choice < 4 && next) {
        ASSERT_TRUE(tasks.take(*next));
        plain.taken.insert(*next);
      } else if (choice < 8 && !plain.taken.empty()) {
        const FrameTask task =
            *std::next(plain.taken.begin(), below(static_cast<std::uint32_t>(plain.taken.size())));
        plain.taken.erase(task);
        if (choice < 7) {
          ASSERT_TRUE(tasks.close(task));
          ASSERT_FALSE(tasks.close(task));
          plain.closed.insert(task);
        } else {
          tasks.reopen(task);
        }
      } else {
        const std::uint32_t tile = below(plain.tiles);
        std::uint32_t& folded = plain.folded[tile];
        if (plain.closed.contains({folded, tile})) {
          ASSERT_EQ(tasks.fold(tile, ++folded), 0);
        }
        ASSERT_EQ(tasks.folded(tile), folded);
      }
      const FrameTask any{below(plain.passes), below(plain.tiles)};
      ASSERT_EQ(tasks.state(any), plain.state(any));
    }
  }
}

TEST(FrameTasks, FinishWhenEveryPassOfEveryTileIsFolded) {
  FrameTasks tasks(std::make_shared<const TileRanks>(2U), 2, 3);
  EXPECT_EQ(tasks.fold(0, 2), 2) << "folded from a checkpoint: closed by it";
  EXPECT_EQ(tasks.fold(1, 1), 1);
  EXPECT_FALSE(tasks.finished());
  EXPECT_EQ(tasks.fold(1, 1), 0);
  EXPECT_EQ(tasks.fold(1, 2), 1);
  EXPECT_TRUE(tasks.finished());
}

TEST(FrameTasks, RememberWhatWasClosedBeforeAnythingIsFolded) {
  FrameTasks tasks(std::make_shared<const TileRanks>(1U), 100, 3);
  for (std::uint32_t pass = 0; pass < 80; ++pass) EXPECT_TRUE(tasks.close({pass, 0}));
  EXPECT_TRUE(tasks.close({81, 0}));
  EXPECT_FALSE(tasks.peek()) << "nothing is folded";
  EXPECT_EQ(tasks.fold(0, 79), 0);
  EXPECT_EQ(tasks.peek(), (FrameTask{80, 0}));
}

}  // namespace
}  // namespace tessera::server
