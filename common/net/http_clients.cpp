#include "common/net/http_clients.hpp"

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <utility>

#include "common/base/error.hpp"

namespace tessera::net {

namespace asio = boost::asio;

HttpClients::HttpClients(asio::any_io_executor executor, std::string_view base_url,
                         const std::string& token, std::size_t count)
    : executor_(std::move(executor)) {
  clients_.reserve(count);
  for (std::size_t i = 0; i < count; ++i) clients_.emplace_back(executor_, base_url, token);
}

void HttpClients::run(Task task, std::function<void(std::exception_ptr)> ended) {
  task_ = std::move(task);
  ended_ = std::move(ended);
  first_error_ = nullptr;
  cancelled_ = false;
  running_ = clients_.size();
  for (HttpClient& client : clients_)
    asio::co_spawn(executor_, task_(client),
                   [this](std::exception_ptr error) { one_ended(std::move(error)); });
}

void HttpClients::one_ended(std::exception_ptr error) {
  if (error && !first_error_) {
    first_error_ = std::move(error);
    cancel();
  }
  if (--running_ == 0) std::exchange(ended_, nullptr)(std::exchange(first_error_, nullptr));
}

asio::awaitable<void> HttpClients::pause(Duration time) {
  const auto timer = pauses_.emplace(pauses_.end(), executor_, time);
  boost::system::error_code ignored;
  if (!cancelled_) co_await timer->async_wait(asio::redirect_error(asio::use_awaitable, ignored));
  pauses_.erase(timer);
  if (cancelled_) throw Error(ErrorKind::failed, "cancelled");
}

void HttpClients::cancel() {
  cancelled_ = true;
  for (HttpClient& client : clients_) client.cancel();
  for (asio::steady_timer& timer : pauses_) timer.cancel();
}

}  // namespace tessera::net
