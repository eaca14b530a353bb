#include <fmt/format.h>

#include <chrono>

#include "server/http/handlers.hpp"

namespace tessera::server {

namespace {

/// One event in the form of the HTML standard, 9.2.
std::string event_text(const Event& event) {
  std::string out = fmt::format("id: {}\nevent: {}\n", event.number, event.type);
  std::string_view rest = event.data;
  do {  // a line break within the data begins another data line
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    out += fmt::format("data: {}\n", rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  } while (!rest.empty());
  return out + "\n";
}

class EventStream : public TextStream {
 public:
  EventStream(std::unique_ptr<Subscription> subscription, Duration keep_alive)
      : subscription_(std::move(subscription)), keep_alive_(keep_alive) {}

  boost::asio::awaitable<std::optional<std::string>> next() override {
    if (!started_) {
      started_ = true;
      co_return "retry: 1000\n: connected\n\n";
    }
    const auto before = std::chrono::steady_clock::now();
    const auto event = co_await subscription_->next(keep_alive_);
    if (event) co_return event_text(*event);
    // Nothing comes too early only when the coordinator stops.
    if (std::chrono::steady_clock::now() - before < keep_alive_ / 2) co_return std::nullopt;
    co_return ": keep-alive\n\n";
  }

 private:
  std::unique_ptr<Subscription> subscription_;
  Duration keep_alive_;
  bool started_ = false;
};

HttpResponse stream_of(const Call& call, std::optional<JobId> job) {
  HttpResponse response;
  response.fields = {{"Content-Type", "text/event-stream"}, {"Cache-Control", "no-store"}};
  response.body = std::make_shared<EventStream>(call.api.coordinator.subscribe(job),
                                                call.api.settings.keep_alive);
  return response;
}

}  // namespace

HandlerResult job_events(Call& call) {
  const JobId id = job_of(call).view.id;
  co_return stream_of(call, id);
}

HandlerResult all_events(Call& call) { co_return stream_of(call, std::nullopt); }

}  // namespace tessera::server
