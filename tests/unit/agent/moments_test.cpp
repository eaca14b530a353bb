#include "worker/agent/moments.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

namespace tessera::agent {
namespace {

using Built = std::shared_ptr<const double>;

TEST(Moments, builds_each_moment_once_however_many_ask_at_the_same_time) {
  Moments<double> moments(2);
  std::atomic<int> builds = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < 8; ++i)
    threads.emplace_back([&, time = i % 2] {
      const Built built = moments.at(time, [&] {
        ++builds;
        std::this_thread::yield();
        return std::make_shared<const double>(time);
      });
      EXPECT_EQ(*built, time);
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(builds, 2);
}

TEST(Moments, does_not_let_go_of_one_that_is_being_built) {
  Moments<double> moments(1);
  int builds = 0;
  const auto other = [] { return std::make_shared<const double>(2); };
  const Built built = moments.at(1, [&]() -> Built {
    ++builds;
    (void)moments.at(2, other);  // another thread's, meanwhile
    (void)moments.at(3, other);
    return std::make_shared<const double>(1);
  });
  EXPECT_EQ(moments.at(1, [&] { return ++builds, built; }), built);
  EXPECT_EQ(builds, 1);
  EXPECT_TRUE(moments.has(1));
  EXPECT_FALSE(moments.has(2));
}

TEST(Moments, keeps_those_asked_for_last) {
  Moments<double> moments(2);
  std::vector<double> built;
  const auto ask = [&](double time) {
    (void)moments.at(time, [&] {
      built.push_back(time);
      return std::make_shared<const double>(time);
    });
  };
  for (const double time : {1.0, 2.0, 1.0, 3.0, 1.0, 2.0}) ask(time);
  EXPECT_EQ(built, (std::vector<double>{1, 2, 3, 2}));
}

TEST(Moments, a_build_that_failed_or_was_given_up_is_tried_again) {
  Moments<double> moments(2);
  EXPECT_THROW((void)moments.at(1, []() -> Built { throw std::runtime_error("no file"); }),
               std::runtime_error);
  EXPECT_EQ(moments.at(1, [] { return Built(); }), nullptr);
  EXPECT_EQ(*moments.at(1, [] { return std::make_shared<const double>(7); }), 7);
}

}  // namespace
}  // namespace tessera::agent
