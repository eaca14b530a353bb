#include "client/server.hpp"

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <exception>
#include <nlohmann/json.hpp>
#include <optional>

#include "client/interrupt.hpp"
#include "common/base/error.hpp"

namespace tessera::client {

namespace {
/// How often a blocking call looks whether a signal came.
constexpr std::chrono::milliseconds look{50};
/// Nothing on an event stream for so long, not even a comment: the stream is dead.
constexpr std::chrono::seconds event_silence{30};
}  // namespace

struct Server::State {
  explicit State(const Settings& with)
      : settings(with),
        client(context.get_executor(), settings.server, settings.token),
        events(context.get_executor(), settings.server, settings.token) {}

  /// Runs the loop until `done`. When a signal comes, what is under way at `clients` is cancelled,
  /// awaited, and Interrupted thrown.
  template <class Clients>
  void run_until(const bool& done, Clients& clients) {
    bool cancelled = false;
    context.restart();
    while (!done) {
      if (interrupted() && !cancelled) {
        cancelled = true;
        clients.cancel();
      }
      context.run_one_for(look);
      if (context.stopped()) context.restart();
    }
    if (interrupted()) throw Interrupted{};
  }

  NotedInterrupts noted;
  Settings settings;
  boost::asio::io_context context{1};
  net::HttpClient client;
  net::HttpClient events;
  bool listening = false;
  bool woken = false;
};

Server::Server(const Settings& settings) : state_(std::make_unique<State>(settings)) {}

Server::~Server() {
  if (!state_->listening) return;
  state_->events.cancel();
  state_->context.restart();
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(5);
  while (state_->listening && std::chrono::steady_clock::now() < give_up)
    state_->context.run_one_for(look);
}

net::HttpResponse Server::send(net::HttpRequest request) {
  bool done = false;
  std::exception_ptr error;
  net::HttpResponse response;
  boost::asio::co_spawn(state_->context, state_->client.send(std::move(request)),
                        [&](std::exception_ptr thrown, net::HttpResponse got) {
                          error = std::move(thrown);
                          response = std::move(got);
                          done = true;
                        });
  state_->run_until(done, state_->client);
  if (error) std::rethrow_exception(error);
  return response;
}

void Server::download(const std::string& target,
                      std::function<void(std::span<const std::byte>)> sink) {
  bool done = false;
  std::exception_ptr error;
  net::HttpRequest request;
  request.target = target;
  boost::asio::co_spawn(state_->context,
                        state_->client.download(std::move(request), std::move(sink)),
                        [&](std::exception_ptr thrown, const net::HttpResponse&) {
                          error = std::move(thrown);
                          done = true;
                        });
  state_->run_until(done, state_->client);
  if (error) std::rethrow_exception(error);
}

void Server::concurrently(std::size_t count, const Task& task) {
  bool done = false;
  std::exception_ptr error;
  net::HttpClients clients(state_->context.get_executor(), state_->settings.server,
                           state_->settings.token, count);
  clients.run([&](net::HttpClient& client) { return task(clients, client); },
              [&](std::exception_ptr thrown) {
                error = std::move(thrown);
                done = true;
              });
  state_->run_until(done, clients);
  if (error) std::rethrow_exception(error);
}

Json Server::json_of(const net::HttpResponse& response, const std::string& target) const {
  try {
    return parse_json(response.body, url() + target);
  } catch (const Error& error) {
    throw Error(ErrorKind::failed, "the server's answer cannot be read: " + error.message(),
                error.place());
  }
}

Json Server::get(const std::string& target) {
  net::HttpRequest request;
  request.target = target;
  return json_of(send(std::move(request)), target);
}

namespace {
net::HttpRequest json_request(const char* method, const std::string& target, const Json& body) {
  net::HttpRequest request;
  request.method = method;
  request.target = target;
  request.headers.emplace_back("Content-Type", "application/json");
  request.body = body.dump();
  return request;
}
}  // namespace

Json Server::post(const std::string& target, const Json& body) {
  return json_of(send(json_request("POST", target, body)), target);
}

Json Server::post_once(const std::string& target, const Json& body, const std::string& key) {
  net::HttpRequest request = json_request("POST", target, body);
  request.headers.emplace_back("Idempotency-Key", '"' + key + '"');
  return json_of(send(std::move(request)), target);
}

Json Server::put(const std::string& target, const Json& body) {
  return json_of(send(json_request("PUT", target, body)), target);
}

Json Server::patch(const std::string& target, const Json& body) {
  return json_of(send(json_request("PATCH", target, body)), target);
}

Json Server::remove(const std::string& target) {
  net::HttpRequest request;
  request.method = "DELETE";
  request.target = target;
  return json_of(send(std::move(request)), target);
}

void Server::listen(const std::string& target) {
  if (state_->listening) return;
  state_->listening = true;
  State& state = *state_;
  std::function<bool(const net::ServerEvent&)> sink = [&state](const net::ServerEvent&) {
    state.woken = true;
    return true;
  };
  boost::asio::co_spawn(state.context,
                        state.events.events(target, std::string(), event_silence, std::move(sink)),
                        [&state](const std::exception_ptr&) { state.listening = false; });
}

bool Server::listening() const { return state_->listening; }

void Server::pause(Duration least, Duration most) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  bool expired = false;
  boost::asio::steady_timer timer(state_->context);  // also keeps the loop from running out of work
  for (;;) {
    throw_if_interrupted();
    const Duration spent = Clock::now() - start;
    if (spent >= most || (spent >= least && state_->woken)) break;
    const Duration left = (state_->woken ? least : most) - spent;
    expired = false;
    timer.expires_after(std::min<Duration>(left, look));
    timer.async_wait([&expired](const boost::system::error_code&) { expired = true; });
    state_->context.restart();
    const bool waited_for = state_->woken;
    while (!expired && state_->woken == waited_for) state_->context.run_one();
    timer.cancel();
    while (!expired) state_->context.run_one();
  }
  state_->woken = false;
}

const std::string& Server::url() const { return state_->client.base_url(); }

}  // namespace tessera::client
