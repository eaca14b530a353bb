#include <gmock/gmock.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/use_awaitable.hpp>

#include "common/base/limits.hpp"
#include "server/coordinator/event_hub.hpp"
#include "server/coordinator/frame_throttle.hpp"

namespace tessera::server {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::Pair;

Instant at(int ms) { return Instant(milliseconds(1000 + ms)); }

TEST(FrameThrottle, FirstNewsIsToldAtOnceAndTheNextAfterItsSpacing) {
  FrameThrottle throttle(milliseconds(80));
  throttle.changed(1, 5, at(0));
  EXPECT_EQ(throttle.next_deadline(), at(0));
  EXPECT_THAT(throttle.due(at(0)), ElementsAre(Pair(1, 5)));
  EXPECT_EQ(throttle.next_deadline(), std::nullopt);
  for (int ms = 1; ms < 80; ++ms) {
    throttle.changed(1, 5, at(ms));
    EXPECT_THAT(throttle.due(at(ms)), IsEmpty());
  }
  EXPECT_EQ(throttle.next_deadline(), at(80));
  EXPECT_THAT(throttle.due(at(80)), ElementsAre(Pair(1, 5)));
}

TEST(FrameThrottle, AForgottenJobsLastNewsIsToldAtOnce) {
  FrameThrottle throttle(milliseconds(80));
  const Instant start{};
  throttle.changed(1, 5, start);
  EXPECT_EQ(throttle.due(start).size(), 1U);
  throttle.changed(1, 6, start);
  throttle.changed(2, 7, start);
  EXPECT_EQ(throttle.forget(1), (std::vector<FrameThrottle::Frame>{{1, 6}}));
  EXPECT_TRUE(throttle.forget(1).empty());
  EXPECT_EQ(throttle.due(start), (std::vector<FrameThrottle::Frame>{{2, 7}}));
}

TEST(FrameThrottle, FramesOfAJobTakeTurnsAndJobsDoNotWaitForEachOther) {
  FrameThrottle throttle(milliseconds(80));
  throttle.changed(1, 5, at(0));
  throttle.changed(1, 6, at(0));
  throttle.changed(1, 5, at(0));
  throttle.changed(2, 1, at(0));
  EXPECT_THAT(throttle.due(at(0)), ElementsAre(Pair(1, 5), Pair(2, 1)));
  throttle.changed(1, 5, at(1));
  EXPECT_THAT(throttle.due(at(80)), ElementsAre(Pair(1, 6)));
  EXPECT_THAT(throttle.due(at(160)), ElementsAre(Pair(1, 5)));
  EXPECT_THAT(throttle.due(at(240)), IsEmpty());
}

template <class T>
T run(boost::asio::io_context& io, boost::asio::awaitable<T> coroutine) {
  std::optional<T> out;
  boost::asio::co_spawn(io, std::move(coroutine),
                        [&](const std::exception_ptr&, T value) { out = std::move(value); });
  io.restart();
  io.run();
  return std::move(*out);
}

TEST(EventHub, ListenersGetWhatConcernsThemInOrder) {
  boost::asio::io_context io;
  EventHub hub(io.get_executor());
  const auto all = hub.subscribe(std::nullopt);
  const auto one = hub.subscribe(JobId{7});
  hub.publish("worker", 0, "{}");
  hub.publish("job", 7, "{\"a\":1}");
  hub.publish("job", 8, "{}");
  EXPECT_EQ(run(io, all->next(milliseconds(1)))->type, "worker");
  EXPECT_EQ(run(io, all->next(milliseconds(1)))->job, 7U);
  EXPECT_EQ(run(io, all->next(milliseconds(1)))->number, 3U);
  EXPECT_FALSE(run(io, all->next(milliseconds(1))));
  EXPECT_EQ(run(io, one->next(milliseconds(1)))->data, "{\"a\":1}");
  EXPECT_FALSE(run(io, one->next(milliseconds(1))));
}

TEST(EventHub, SlowListenerLosesTheOldestAndIsToldHowMany) {
  boost::asio::io_context io;
  EventHub hub(io.get_executor());
  const auto slow = hub.subscribe(std::nullopt);
  for (std::size_t i = 0; i < limits::event_backlog + 10; ++i) hub.publish("job", 1, "{}");
  const auto notice = run(io, slow->next(milliseconds(1)));
  EXPECT_EQ(notice->type, "lost");
  EXPECT_EQ(notice->data, "{\"events\":10}");
  EXPECT_EQ(run(io, slow->next(milliseconds(1)))->number, 11U);
}

TEST(EventHub, SubscriptionMayOutliveTheHub) {
  boost::asio::io_context io;
  auto hub = std::make_unique<EventHub>(io.get_executor());
  const auto listener = hub->subscribe(std::nullopt);
  hub->publish("job", 1, "{}");
  hub.reset();
  EXPECT_TRUE(run(io, listener->next(std::chrono::minutes(1))));
  EXPECT_FALSE(run(io, listener->next(std::chrono::minutes(1))));
}

}  // namespace
}  // namespace tessera::server
