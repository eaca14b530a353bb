#include "tests/unit/session/farm.hpp"

#include <gmock/gmock.h>

#include <functional>
#include <limits>

// What a worker may send that is no result, and what it is told.
namespace tessera::server {
namespace {

using testing::HasSubstr;
using Rejected = CoordinatorCounters::Rejected;

/// One wrong result, and what the worker is told; it is counted as `kind`. Then the job is done by
/// another.
std::string reason_for(
    const std::function<void(wire::Result&, image::TileImage&, std::vector<std::byte>&)>& spoil,
    std::uint64_t Rejected::*kind = &Rejected::tile) {
  Farm farm;
  const JobSpec spec = farm.spec(30, 20, 16, 4);
  JobId id = 0;
  ScriptedWorker cheat("cheat", 'c');
  ScriptedWorker good("good", 'd');
  bool spoiled = false;
  cheat.on_assign = [&](const wire::Assign& order) {
    if (spoiled || order.task.tile != 0 || order.task.pass != 0) return;
    spoiled = true;
    wire::Result result = cheat.result_of(order);
    image::TileImage tile = cheat.tile_of(order);
    std::vector<std::byte> bytes;
    spoil(result, tile, bytes);
    if (bytes.empty()) bytes = image::encode_tile(tile);
    cheat.deliver(result, std::move(bytes));
  };
  const auto scenario = [&]() -> awaitable<void> {
    co_await cheat.connect(farm);
    id = co_await farm.coordinator->submit(spec);
    co_await cheat.work([&] { return !cheat.rejected.empty(); });
    cheat.vanish();
    co_await good.connect(farm);
    co_await good.work([&] { return farm.coordinator->job(id)->view.state == "done"; });
  };
  farm.run(scenario());
  EXPECT_EQ(cheat.accepted, 0U);
  EXPECT_EQ(difference_from_straight_fold(farm, spec, id), std::nullopt);
  const CoordinatorCounters counters = farm.coordinator->counters();
  const Rejected& rejected = counters.rejected;
  EXPECT_EQ(rejected.*kind, 1U);
  EXPECT_EQ(rejected.plan + rejected.task + rejected.lease + rejected.statistics + rejected.tile,
            1U);
  EXPECT_EQ(counters.results_accepted, static_cast<std::uint64_t>(JobPlan(spec).tasks()));
  EXPECT_EQ(counters.workers_joined, 2U);
  EXPECT_EQ(counters.workers_lost, 1U) << "the one that vanished";
  EXPECT_GE(counters.leases_granted, counters.results_accepted);
  return cheat.rejected.empty() ? "" : cheat.rejected.front().reason;
}

TEST(InvalidTile, OfTheWrongSizeIsRejectedWithBothSizes) {
  const std::string reason =
      reason_for([](wire::Result&, image::TileImage& tile, std::vector<std::byte>&) {
        tile.window.width = 8;
        tile.values.resize(tile.channels() * tile.pixels());
      });
  EXPECT_EQ(reason, "tile EXR: data window: expected 16x16 at 0,0, found 8x16 at 0,0");
}

TEST(InvalidTile, WithNaNIsRejectedWithItsPixel) {
  const std::string reason =
      reason_for([](wire::Result&, image::TileImage& tile, std::vector<std::byte>&) {
        tile.plane(image::G)[16 * 2 + 3] = std::numeric_limits<float>::quiet_NaN();
      });
  EXPECT_EQ(reason, "tile EXR: channel G at pixel 3,2: expected a finite number, found nan");
}

TEST(InvalidTile, ThatIsNoEXRIsRejected) {
  const std::string reason =
      reason_for([](wire::Result&, image::TileImage&, std::vector<std::byte>& bytes) {
        bytes.assign(1000, std::byte{'x'});
      });
  EXPECT_EQ(reason, "tile EXR: magic number: expected that of an EXR file, found 0x78787878");
}

TEST(InvalidTile, CutShortIsRejected) {
  const std::string reason =
      reason_for([](wire::Result&, image::TileImage& tile, std::vector<std::byte>& bytes) {
        bytes = image::encode_tile(tile);
        bytes.resize(bytes.size() - 100);
      });
  EXPECT_THAT(reason, HasSubstr("tile EXR"));
}

TEST(InvalidTile, OfAnotherSampleCountIsRejectedWithBothCounts) {
  const std::string reason =
      reason_for([](wire::Result&, image::TileImage& tile, std::vector<std::byte>&) {
        tile.samples = {2, 2};
      });
  EXPECT_THAT(reason, HasSubstr("tessera.samples.beauty"));
  EXPECT_THAT(reason, HasSubstr("expected 1, found 2"));
}

TEST(InvalidTile, WhoseStatisticsDoNotFitIsRejected) {
  const std::string reason = reason_for(
      [](wire::Result& result, image::TileImage&, std::vector<std::byte>&) { result.samples += 5; },
      &Rejected::statistics);
  EXPECT_EQ(reason, "samples: expected 256 for frame 1 tile 0 pass 0, found 261");
}

TEST(InvalidTile, ForALeaseThatItDoesNotHoldIsRejected) {
  const std::string reason =
      reason_for([](wire::Result& result, image::TileImage&,
                    std::vector<std::byte>&) { result.lease.number ^= 0x5a5a; },
                 &Rejected::lease);
  EXPECT_THAT(reason, HasSubstr("was not granted to this worker for frame 1 tile 0 pass 0"));
}

TEST(InvalidTile, OfAnotherPlanIsRejected) {
  const std::string reason = reason_for([](wire::Result& result, image::TileImage&,
                                           std::vector<std::byte>&) { result.plan.bytes[0] ^= 1; },
                                        &Rejected::plan);
  EXPECT_EQ(reason, "the result is of another plan than the job's");
}

}  // namespace
}  // namespace tessera::server
