#include "server/coordinator/writer.hpp"

#include <gtest/gtest.h>

#include <future>
#include <thread>

#include "common/base/error.hpp"
#include "server/coordinator/budget.hpp"

namespace tessera::server {
namespace {

using std::chrono::milliseconds;

ArrivedResult result(std::uint64_t number, std::size_t bytes = 10) {
  ArrivedResult out;
  out.info.lease = {1, number};
  out.exr = std::make_shared<const std::vector<std::byte>>(bytes);
  return out;
}

/// A store that notes what it is given, and can be made to refuse.
struct FakeStore {
  std::vector<ResultPlace> append(std::vector<ArrivedResult>& group) {
    const std::lock_guard lock(mutex);
    ++calls;
    if (failures > 0) {
      --failures;
      throw Error(ErrorKind::failed, "no space left on device");
    }
    sizes.push_back(group.size());
    std::vector<ResultPlace> places;
    for (const ArrivedResult& one : group) places.push_back({1, one.info.lease.number, 1});
    return places;
  }
  bool called(int times) {
    const std::lock_guard lock(mutex);
    return calls >= times;
  }
  std::mutex mutex;
  std::vector<std::size_t> sizes;
  int failures = 0;
  int calls = 0;
};

class WriterTest : public testing::Test {
 protected:
  std::unique_ptr<Writer> writer(WriterSettings settings) {
    return std::make_unique<Writer>(
        [this](std::vector<ArrivedResult>& group) { return store.append(group); },
        Writer::Hooks{[this](std::vector<ArrivedResult> group) {
                        for (const ArrivedResult& one : group) {
                          EXPECT_EQ(one.place.offset, one.info.lease.number);
                          order.push_back(one.info.lease.number);
                        }
                      },
                      [this](const std::string& reason) { refusals.push_back(reason); }},
        settings);
  }
  FakeStore store;
  std::vector<std::uint64_t> order;  ///< as committed; read after stop()
  std::vector<std::string> refusals;
};

TEST_F(WriterTest, WhatWaitsIsMadeDurableInGroupsOfAtMostTheLimit) {
  WriterSettings settings;
  settings.group_results = 4;
  settings.group_bytes = 100;
  const auto under_test = writer(settings);
  std::promise<void> gate;
  under_test->run([&] { gate.get_future().wait(); });
  for (std::uint64_t i = 0; i < 6; ++i)
    under_test->add([&] {
      std::vector<ArrivedResult> one;
      one.push_back(result(i));
      return one;
    }());
  std::vector<ArrivedResult> large;
  large.push_back(result(6, 90));
  large.push_back(result(7, 90));
  large.push_back(result(8, 90));
  under_test->add(std::move(large));
  gate.set_value();
  under_test->stop();
  EXPECT_EQ(store.sizes, (std::vector<std::size_t>{4, 3, 2}));
  EXPECT_EQ(order, (std::vector<std::uint64_t>{0, 1, 2, 3, 4, 5, 6, 7, 8}));
}

TEST_F(WriterTest, WorkRunsBetweenGroupsInItsTurn) {
  const auto under_test = writer({});
  std::promise<void> gate;
  std::size_t before = 99;
  under_test->run([&] { gate.get_future().wait(); });
  std::vector<ArrivedResult> one;
  one.push_back(result(1));
  under_test->add(std::move(one));
  under_test->run([&] { before = order.size(); });
  std::vector<ArrivedResult> two;
  two.push_back(result(2));
  under_test->add(std::move(two));
  gate.set_value();
  under_test->stop();
  EXPECT_EQ(before, 1U);
  EXPECT_EQ(order.size(), 2U);
}

TEST_F(WriterTest, GroupThatTheDiskRefusesIsTriedUntilItIsTaken) {
  store.failures = 3;
  WriterSettings settings;
  settings.retry_first = milliseconds(1);
  const auto under_test = writer(settings);
  std::vector<ArrivedResult> one;
  one.push_back(result(1));
  under_test->add(std::move(one));
  while (!store.called(4)) std::this_thread::sleep_for(milliseconds(1));
  under_test->stop();
  EXPECT_EQ(order, std::vector<std::uint64_t>{1});
  const std::string full = "no space left on device";
  EXPECT_EQ(refusals, (std::vector<std::string>{full, full, full, ""}));
}

TEST_F(WriterTest, WorkIsNotHeldUpByGroupThatTheDiskRefuses) {
  store.failures = 1;
  WriterSettings settings;
  settings.retry_first = std::chrono::hours(1);
  const auto under_test = writer(settings);
  std::vector<ArrivedResult> one;
  one.push_back(result(1));
  under_test->add(std::move(one));
  while (!store.called(1)) std::this_thread::sleep_for(milliseconds(1));
  std::promise<void> done;
  under_test->run([&] { done.set_value(); });
  done.get_future().wait();
  EXPECT_TRUE(order.empty());
}

TEST_F(WriterTest, StopLeavesWhatIsRefusedUnacknowledgedAndFinishesTheRest) {
  store.failures = 1;
  WriterSettings settings;
  settings.retry_first = std::chrono::hours(1);
  settings.group_results = 1;
  const auto under_test = writer(settings);
  std::vector<ArrivedResult> both;
  both.push_back(result(1));
  both.push_back(result(2));
  under_test->add(std::move(both));
  under_test->stop();
  EXPECT_EQ(order, std::vector<std::uint64_t>{2});
}

TEST(Budget, ShareCountsUntilItsLastCopyIsGone) {
  Budget budget;
  auto one = budget.take(100);
  auto copy = one;
  auto two = budget.take(50);
  EXPECT_EQ(budget.used(), 150U);
  one.reset();
  EXPECT_EQ(budget.used(), 150U);
  copy.reset();
  EXPECT_EQ(budget.used(), 50U);
}

}  // namespace
}  // namespace tessera::server
