#include "server/coordinator/event_hub.hpp"

#include <fmt/format.h>

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <deque>

#include "common/base/limits.hpp"

namespace tessera::server {

struct EventHub::Queue {
  Queue(const boost::asio::any_io_executor& executor, std::optional<JobId> of)
      : job(of), wake(executor) {}

  void push(const Event& event) {
    if (events.size() >= limits::event_backlog) {
      events.pop_front();
      ++lost;
    }
    events.push_back(event);
    wake.cancel();
  }

  std::optional<Event> pop() {
    if (lost > 0 && !events.empty()) {
      Event notice{events.front().number - 1, "lost", job.value_or(0),
                   fmt::format(R"({{"events":{}}})", lost)};
      lost = 0;
      return notice;
    }
    if (events.empty()) return std::nullopt;
    Event event = std::move(events.front());
    events.pop_front();
    return event;
  }

  std::optional<JobId> job;
  std::deque<Event> events;
  std::size_t lost = 0;
  bool closed = false;
  boost::asio::steady_timer wake;
};

class EventHub::Listener : public Subscription {
 public:
  explicit Listener(std::shared_ptr<Queue> queue) : queue_(std::move(queue)) {}

  boost::asio::awaitable<std::optional<Event>> next(Duration wait) override {
    const std::shared_ptr<Queue> queue = queue_;
    if (queue->events.empty() && !queue->closed) {
      queue->wake.expires_after(wait);
      co_await queue->wake.async_wait(boost::asio::as_tuple(boost::asio::use_awaitable));
    }
    co_return queue->pop();
  }

 private:
  std::shared_ptr<Queue> queue_;
};

EventHub::EventHub(boost::asio::any_io_executor executor) : executor_(std::move(executor)) {}

EventHub::~EventHub() { close(); }

std::unique_ptr<Subscription> EventHub::subscribe(std::optional<JobId> job) {
  auto queue = std::make_shared<Queue>(executor_, job);
  queue->closed = closed_;
  queues_.push_back(queue);
  return std::make_unique<Listener>(std::move(queue));
}

void EventHub::publish(std::string type, JobId job, std::string data) {
  if (closed_) return;
  const Event event{++last_number_, std::move(type), job, std::move(data)};
  std::erase_if(queues_, [&](const std::weak_ptr<Queue>& weak) {
    const auto queue = weak.lock();
    if (queue && (!queue->job || *queue->job == job)) queue->push(event);
    return !queue;
  });
}

void EventHub::close() {
  closed_ = true;
  for (const auto& weak : queues_)
    if (const auto queue = weak.lock()) {
      queue->closed = true;
      queue->wake.cancel();
    }
}

bool EventHub::has_listeners() {
  std::erase_if(queues_, [](const std::weak_ptr<Queue>& weak) { return weak.expired(); });
  return !queues_.empty();
}

}  // namespace tessera::server
