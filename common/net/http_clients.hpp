#pragma once
#include <boost/asio/steady_timer.hpp>
#include <cstddef>
#include <exception>
#include <functional>
#include <list>
#include <string>
#include <string_view>
#include <vector>

#include "common/net/http_client.hpp"

namespace tessera::net {

/// Several connections to one server, on each of which one thing happens at a time. All calls on
/// the executor.
class HttpClients {
 public:
  using Task = std::function<boost::asio::awaitable<void>(HttpClient&)>;

  /// As HttpClient's, `count` of them.
  HttpClients(boost::asio::any_io_executor executor, std::string_view base_url,
              const std::string& token, std::size_t count);
  HttpClients(const HttpClients&) = delete;
  HttpClients& operator=(const HttpClients&) = delete;

  /// Runs `task` on each connection; where one throws, the others are cancelled. `ended` is told
  /// the first error, or null, when all have ended: only then may this go, or run again.
  void run(Task task, std::function<void(std::exception_ptr)> ended);
  /// A task's rest. Throws Error{failed}, "cancelled", as soon as it is.
  boost::asio::awaitable<void> pause(Duration time);
  /// Ends what is under way, and pauses, with Error{failed}, "cancelled"; what is not under way
  /// must ask cancelled().
  void cancel();
  [[nodiscard]] bool cancelled() const { return cancelled_; }

 private:
  void one_ended(std::exception_ptr error);

  boost::asio::any_io_executor executor_;
  std::vector<HttpClient> clients_;
  Task task_;
  std::function<void(std::exception_ptr)> ended_;
  std::size_t running_ = 0;
  std::exception_ptr first_error_;
  std::list<boost::asio::steady_timer> pauses_;
  bool cancelled_ = false;
};

}  // namespace tessera::net
