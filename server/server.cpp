#include "server/server.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/thread_pool.hpp>
#include <nlohmann/json.hpp>

#include "common/assets/blob_store.hpp"
#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "common/base/random.hpp"
#include "server/coordinator/coordinator.hpp"
#include "server/http/api.hpp"
#include "server/http/listener.hpp"
#include "server/quantities.hpp"
#include "server/session/listener.hpp"

namespace tessera::server {

namespace {

constexpr std::size_t token_least = 16;  ///< characters, off loopback
constexpr std::size_t file_threads = 2;

[[noreturn]] void bad(const std::string& message) { throw Error(ErrorKind::bad_input, message); }

void check_address(const ServerSettings& settings, const char* flag, const net::Address& address) {
  boost::system::error_code error;
  boost::asio::ip::make_address(address.host, error);
  if (error)
    bad(fmt::format("{} {}: expected an IP address to listen on, such as 127.0.0.1 or 0.0.0.0",
                    flag, address.text()));
  if (net::is_loopback(address.host)) return;
  if (settings.token.empty())
    bad(
        fmt::format("{} {} can be reached from other machines: give a token that all must show "
                    "(--token, --token-file or "
                    "TESSERA_TOKEN), or listen on 127.0.0.1",
                    flag, address.text()));
  if (settings.token.size() < token_least)
    bad(fmt::format(
        "the token must have at least {} characters where other machines can reach the server",
        token_least));
  if (!settings.insecure)
    bad(
        fmt::format("{} {} can be reached from other machines, and this server does not encrypt: "
                    "token and pictures would go in "
                    "the clear. Give --insecure as well if the network can be trusted",
                    flag, address.text()));
}

std::string url_base(std::string url) {
  while (!url.empty() && url.back() == '/') url.pop_back();
  return url;
}

}  // namespace

void check(const ServerSettings& settings) {
  const bool plain = std::all_of(settings.token.begin(), settings.token.end(),
                                 [](char c) { return c > ' ' && c <= '~'; });
  if (!plain || settings.token.size() > 512)
    bad("a token has at most 512 characters, all of them visible ASCII");
  const std::string& url = settings.public_url;
  if (!url.empty() && !url.starts_with("http://") && !url.starts_with("https://"))
    bad(fmt::format("--public-url {}: expected http://HOST:PORT or https://HOST:PORT", url));
  if (settings.pool_threads < 1 || settings.pool_threads > 256)
    bad("--pool-threads: expected a number from 1 to 256");
  if (settings.preparation_timeout < 1 || settings.preparation_timeout > 1'000'000)
    bad("--preparation-timeout: expected a number of seconds from 1 to 1000000");
  check_address(settings, "--http", settings.http);
  check_address(settings, "--listen", settings.listen);
}

struct Server::State {
  State(boost::asio::io_context& context, ServerSettings given)
      : settings(checked(std::move(given))),
        coordinator(Coordinator::open(context.get_executor(), coordinator_settings(settings))),
        blobs(settings.data / "blobs", settings.durable),
        api(*coordinator, blobs, files, api_settings(settings, blob_token)) {
    try {
      listen(context);
    } catch (...) {
      abandon(context);
      throw;
    }
  }
  ~State() { files.join(); }

  void listen(boost::asio::io_context& context) {
    HttpSettings http;
    http.address = settings.http.host;
    http.port = settings.http.port;
    http_listener = HttpListener::open(context.get_executor(), api, files, http);
    settings.http.port = http_listener->port();
    worker_listener =
        WorkerListener::open(context.get_executor(), *coordinator, session_settings());
    settings.listen.port = worker_listener->port();
  }

  static ServerSettings checked(ServerSettings settings) {
    check(settings);
    return settings;
  }
  static CoordinatorSettings coordinator_settings(const ServerSettings& settings) {
    CoordinatorSettings out;
    out.data = settings.data;
    out.pool_threads = settings.pool_threads;
    out.durable = settings.durable;
    out.scheduler.preparation = std::chrono::seconds(settings.preparation_timeout);
    out.film_memory = settings.film_memory > 0 ? settings.film_memory : machine_memory() / 2;
    out.keep_jobs = settings.keep_jobs;
    out.disk_limit = settings.disk_limit;
    out.blob_cache = settings.blob_cache;
    return out;
  }
  static ApiSettings api_settings(const ServerSettings& settings, const std::string& blob_token) {
    ApiSettings out;
    out.access.token = settings.token;
    out.access.blob_token = blob_token;
    out.access.public_url = settings.public_url;
    out.access.loopback = net::is_loopback(settings.http.host);
    return out;
  }
  [[nodiscard]] SessionSettings session_settings() const {
    SessionSettings out;
    out.address = settings.listen.host;
    out.port = settings.listen.port;
    out.token = settings.token;
    out.blob_url = url_base(settings.public_url);
    out.http_port = settings.http.port;
    out.blob_token = blob_token;
    return out;
  }

  /// Half of it stands, and its coroutines must end before it goes.
  void abandon(boost::asio::io_context& context) {
    bool stopped = false;
    boost::asio::co_spawn(context, stop(), [&](const std::exception_ptr&) { stopped = true; });
    while (!stopped && context.run_one() > 0) {
    }
    context.restart();
  }

  boost::asio::awaitable<void> stop() {
    if (http_listener) co_await http_listener->stop();
    if (worker_listener) co_await worker_listener->stop();
    co_await coordinator->stop();
  }

  ServerSettings settings;
  /// New at every start; workers are given it, to read blobs with.
  std::string blob_token = settings.token.empty() ? std::string() : random_hex(32);
  std::unique_ptr<Coordinator> coordinator;
  assets::BlobStore blobs;
  boost::asio::thread_pool files{file_threads};
  Api api;
  std::unique_ptr<HttpListener> http_listener;
  std::unique_ptr<WorkerListener> worker_listener;
};

Server::Server(boost::asio::io_context& context, ServerSettings settings)
    : state_(std::make_unique<State>(context, std::move(settings))) {
  const ServerSettings& now = state_->settings;
  log::info("HTTP on {}, workers on {}, data in {}", http().text(), listen().text(),
            now.data.string());
  if (net::is_loopback(http().host) && !net::is_loopback(listen().host) && now.public_url.empty())
    log::warn(
        "workers on other machines cannot fetch scenes: HTTP listens on {} alone; --http or "
        "--public-url changes that",
        http().text());
}

Server::~Server() = default;

const net::Address& Server::http() const { return state_->settings.http; }
const net::Address& Server::listen() const { return state_->settings.listen; }

std::string Server::ready_line() const {
  Json line = Json::object();
  line["http"] = http().text();
  line["listen"] = listen().text();
  return line.dump();
}

boost::asio::awaitable<void> Server::stop() { co_await state_->stop(); }

}  // namespace tessera::server
