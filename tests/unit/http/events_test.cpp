#include "api_fixture.hpp"

namespace tessera::server {
namespace {

using testing::ElementsAre;

class EventsTest : public ApiTest {
 protected:
  std::optional<std::string> next(const HttpResponse& response) {
    const auto stream = std::get<std::shared_ptr<TextStream>>(response.body);
    return finish(context, stream->next());
  }
};

TEST_F(EventsTest, AreSentInTheFormOfServerSentEvents) {
  coordinator.add(2);
  coordinator.events.push_back(FakeCoordinator::event(41, "frame", 2, R"({"version":9})"));
  const HttpResponse response = ask("GET", "/v1/jobs/2/events", {}, {{"last-event-id", "17"}});
  EXPECT_EQ(response.field("Content-Type"), "text/event-stream");
  EXPECT_THAT(coordinator.calls, ElementsAre("subscribe 2"));
  EXPECT_EQ(next(response), "retry: 1000\n: connected\n\n");
  EXPECT_EQ(next(response), "id: 41\nevent: frame\ndata: {\"version\":9}\n\n");
}

TEST_F(EventsTest, ALineBreakInTheDataCannotForgeAField) {
  coordinator.events.push_back(FakeCoordinator::event(1, "job", 2, "a\nid: 99"));
  const HttpResponse response = ask("GET", "/v1/events");
  next(response);
  EXPECT_EQ(next(response), "id: 1\nevent: job\ndata: a\ndata: id: 99\n\n");
}

TEST_F(EventsTest, OfAnUnknownJobAre404) {
  EXPECT_EQ(ask("GET", "/v1/jobs/2/events").status, 404U);
  EXPECT_EQ(ask("GET", "/v1/events").status, 200U);
  EXPECT_THAT(coordinator.calls, ElementsAre("subscribe all"));
}

TEST_F(EventsTest, EndWhenTheCoordinatorStops) {
  const HttpResponse response = ask("GET", "/v1/events");
  next(response);
  coordinator.stopped = true;
  EXPECT_EQ(next(response), std::nullopt);
}

}  // namespace
}  // namespace tessera::server
