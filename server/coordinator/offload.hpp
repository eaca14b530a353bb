#pragma once
#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/associated_executor.hpp>
#include <boost/asio/async_result.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>

/// Work on another thread whose result comes back to the coroutine that asked for it.
namespace tessera::server {

/// Hands `work` to `post` (which runs it on some other thread, once) and resumes on the awaiting
/// coroutine's executor with what it returned, or with what it threw. Cancelling the coroutine does
/// not stop the work: it resumes when it is done. `Work` returns a value that can be moved, and
/// made by default.
template <class Result>
boost::asio::awaitable<Result> offload(std::function<void(std::function<void()>)> post,
                                       std::function<Result()> work) {
  auto initiation = [](auto handler, std::function<void(std::function<void()>)> give,
                       std::function<Result()> todo) {
    auto shared = std::make_shared<decltype(handler)>(std::move(handler));
    give([shared, todo = std::move(todo)] {
      std::exception_ptr error;
      auto result = std::make_shared<Result>();
      try {
        *result = todo();
      } catch (...) {
        error = std::current_exception();
      }
      const auto executor = boost::asio::get_associated_executor(*shared);
      boost::asio::post(
          executor, [shared, error, result] { std::move (*shared)(error, std::move(*result)); });
    });
  };
  co_return co_await boost::asio::async_initiate<const boost::asio::use_awaitable_t<>,
                                                 void(std::exception_ptr, Result)>(
      initiation, boost::asio::use_awaitable, std::move(post), std::move(work));
}

/// The same on a thread of the pool.
template <class Result>
boost::asio::awaitable<Result> on(boost::asio::thread_pool& lane, std::function<Result()> work) {
  std::function<void(std::function<void()>)> post = [&lane](std::function<void()> todo) {
    boost::asio::post(lane, std::move(todo));
  };
  return offload<Result>(std::move(post), std::move(work));
}

}  // namespace tessera::server
