#include "worker/agent/scene_bin.hpp"

#include <gtest/gtest.h>

#include "tests/unit/agent/fakes.hpp"

namespace tessera::agent {
namespace {

class SceneBinTest : public testing::Test {
 protected:
  ~SceneBinTest() override { hold = false; }

  /// It takes as long to be freed as `hold` is set.
  std::shared_ptr<const PreparedScene> scene() {
    return std::make_shared<const FakeScene>(true, [this] {
      ++begun;
      while (hold) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      ++freed;
    });
  }

  std::atomic<bool> hold = false;
  std::atomic<int> begun = 0, freed = 0;
  std::stop_source stop;
};

TEST_F(SceneBinTest, who_waits_for_it_finds_all_of_it_freed) {
  SceneBin bin;
  hold = true;
  bin.put({scene(), scene()});
  while (begun == 0) std::this_thread::yield();
  bin.put({scene()});
  EXPECT_EQ(freed, 0);
  std::thread release([this] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    hold = false;
  });
  bin.wait_until_empty(stop.get_token());
  EXPECT_EQ(freed, 3);
  release.join();
}

TEST_F(SceneBinTest, a_scene_that_others_have_is_not_waited_for) {
  SceneBin bin;
  const auto kept = scene();
  bin.put({kept});
  bin.wait_until_empty(stop.get_token());
  EXPECT_EQ(freed, 0);
}

TEST_F(SceneBinTest, who_is_stopped_waits_no_longer) {
  SceneBin bin;
  hold = true;
  bin.put({scene()});
  stop.request_stop();
  bin.wait_until_empty(stop.get_token());
  EXPECT_EQ(freed, 0);
  hold = false;
}

TEST_F(SceneBinTest, its_end_waits_for_what_is_in_it) {
  {
    SceneBin bin;
    bin.put({scene(), scene()});
  }
  EXPECT_EQ(freed, 2);
}

}  // namespace
}  // namespace tessera::agent
