#pragma once
#include <memory>
#include <string>
#include <string_view>

#include "client/settings.hpp"
#include "common/base/clock.hpp"
#include "common/base/json.hpp"
#include "common/net/http_clients.hpp"

namespace tessera::client {

/// The coordinator's HTTP port, one blocking call at a time. Every call throws what HttpClient's
/// does, and Interrupted when a signal came. Owns the event loop that it all runs on.
class Server {
 public:
  explicit Server(const Settings& settings);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// Any request.
  net::HttpResponse send(net::HttpRequest request);
  /// The answer's JSON.
  Json get(const std::string& target);
  Json post(const std::string& target, const Json& body);
  /// The same under an idempotency key, so that it may be repeated where an answer was lost.
  Json post_once(const std::string& target, const Json& body, const std::string& key);
  Json put(const std::string& target, const Json& body);
  Json patch(const std::string& target, const Json& body);
  Json remove(const std::string& target);
  /// The body goes to `sink` piece by piece.
  void download(const std::string& target, std::function<void(std::span<const std::byte>)> sink);

  /// Runs `task` on `count` connections of their own at once, until all have ended.
  using Task =
      std::function<boost::asio::awaitable<void>(net::HttpClients& all, net::HttpClient& client)>;
  void concurrently(std::size_t count, const Task& task);

  /// Listens to server-sent events of `target` from now on, in the background of the other calls.
  /// Where the stream breaks it is simply gone; call again to have another.
  void listen(const std::string& target);
  [[nodiscard]] bool listening() const;
  /// Until `most` has passed, or an event has come since the last pause; but `least` in any case.
  void pause(Duration least, Duration most);

  [[nodiscard]] const std::string& url() const;

 private:
  struct State;
  Json json_of(const net::HttpResponse& response, const std::string& target) const;
  std::unique_ptr<State> state_;
};

}  // namespace tessera::client
