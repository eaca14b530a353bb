// A coordinator that stands still: stopped, suspended, or at something that took too long.
#include <gtest/gtest.h>

#include <thread>

#include "tests/unit/session/farm.hpp"

namespace tessera::server {
namespace {

class Standstill : public testing::Test {
 protected:
  Standstill() {
    farm.run(farm.halt());
    farm.io.reset();
    farm.silence = std::chrono::milliseconds(1800);
    farm.start();
  }
  /// Longer than a worker may be silent, but not by what counts as having stood still.
  static void stand_still() { std::this_thread::sleep_for(std::chrono::milliseconds(2200)); }

  Farm farm;
  ScriptedWorker worker{"patient"};
};

TEST_F(Standstill, OfTheCoordinatorIsNoSilenceOfItsWorkers) {
  const auto scenario = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    co_await sleep_for(std::chrono::milliseconds(50));  // the clock is set
    stand_still();
    co_await sleep_for(std::chrono::milliseconds(300));
  };
  farm.run(scenario());
  EXPECT_EQ(farm.coordinator->counters().workers_lost, 0U);
}

TEST_F(Standstill, JustWhenItsClockIsToBeSetAnewIsNoSilenceEither) {
  const auto scenario = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    co_await sleep_for(std::chrono::milliseconds(50));
    co_await farm.coordinator->submit(farm.spec());  // orders go out, and the clock is woken
    stand_still();
    co_await sleep_for(std::chrono::milliseconds(300));
  };
  farm.run(scenario());
  EXPECT_EQ(farm.coordinator->counters().workers_lost, 0U);
}

TEST_F(Standstill, EndsAndWhoIsSilentFromThereOnIsLost) {
  const auto scenario = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    co_await sleep_for(std::chrono::milliseconds(50));
    stand_still();
    while (farm.coordinator->counters().workers_lost == 0)
      co_await sleep_for(std::chrono::milliseconds(20));
  };
  farm.run(scenario(), std::chrono::seconds(20));
}

}  // namespace
}  // namespace tessera::server
