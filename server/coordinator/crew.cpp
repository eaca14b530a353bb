#include "server/coordinator/crew.hpp"

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/use_awaitable.hpp>

#include "common/base/log.hpp"

namespace tessera::server {

namespace {
constexpr auto as_values = boost::asio::as_tuple(boost::asio::use_awaitable);
}

Signal::Signal(const boost::asio::any_io_executor& executor)
    : timer_(std::make_shared<boost::asio::steady_timer>(
          executor, boost::asio::steady_timer::time_point::max())) {}

void Signal::notify() { timer_->cancel(); }

boost::asio::awaitable<void> Signal::wait() {
  const auto timer = timer_;
  co_await timer->async_wait(as_values);
}

Crew::Crew(const boost::asio::any_io_executor& executor)
    : executor_(executor), all_ended_(executor) {}

void Crew::start(const char* name, boost::asio::awaitable<void> coroutine) {
  begun();
  boost::asio::co_spawn(executor_, std::move(coroutine),
                        [this, name](const std::exception_ptr& error) {
                          try {
                            if (error) std::rethrow_exception(error);
                          } catch (const std::exception& unexpected) {
                            log::error("{}: {}", name, unexpected.what());
                          }
                          finished();
                        });
}

void Crew::finished() {
  if (--running_ == 0) all_ended_.notify();
}

void Crew::stop() {
  stopping_ = true;
  for (boost::asio::steady_timer* timer : pauses_) timer->cancel();
}

boost::asio::awaitable<void> Crew::pause(Duration time) {
  if (stopping_) co_return;
  boost::asio::steady_timer timer(executor_, time);
  pauses_.push_back(&timer);
  co_await timer.async_wait(as_values);
  std::erase(pauses_, &timer);
}

boost::asio::awaitable<void> Crew::ended() {
  while (running_ > 0) co_await all_ended_.wait();
}

}  // namespace tessera::server
