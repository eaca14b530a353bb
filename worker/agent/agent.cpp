#include "worker/agent/agent.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <optional>
#include <utility>

#include "common/assets/blob_store.hpp"
#include "common/base/build_info.hpp"
#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "common/base/random.hpp"
#include "common/net/framed_stream.hpp"
#include "common/wire/codec.hpp"
#include "worker/agent/preparer.hpp"

namespace tessera::agent {

namespace asio = boost::asio;

namespace {
/// How long one wait for messages lasts at most, so that what changed meanwhile is seen to.
constexpr Duration longest_wait = std::chrono::milliseconds(100);
/// Results wait in the outbox; the stream must take them all, and a little more.
constexpr std::size_t queue_bytes = 2 * limits::worker_outbox + limits::wire_body;

Instant now() { return std::chrono::steady_clock::now(); }

std::uint64_t jitter_of(const std::string& identity) {
  return std::stoull(identity.substr(0, 16), nullptr, 16);
}
}  // namespace

struct Agent::Impl : std::enable_shared_from_this<Impl> {
  Impl(asio::io_context& context, AgentSettings with, TaskRenderer& renders);

  asio::io_context& io;
  AgentSettings settings;
  TaskRenderer& renderer;
  std::string identity = random_hex(16);
  assets::BlobStore cache;
  Fetcher fetcher;
  AgentState state;
  asio::steady_timer wake;  ///< ends the wait between two connections
  std::optional<net::FramedStream> stream;
  std::optional<int> exit;
  std::optional<Instant> drain_began;
  bool giving_up = false;  ///< draining took too long
  bool bye_said = false;
  std::string last_trouble;  ///< so that the same is not logged at each try
  // Last: their threads are joined before anything else goes.
  std::unique_ptr<Crew> crew;
  std::unique_ptr<Preparer> preparer;

  void start_threads();
  void pump();
  void task_ended(TaskEnd end);
  void prepare_ended(PrepareEnd end);
  void check_drain();
  void trouble(const std::string& what);
  asio::awaitable<int> run();
  asio::awaitable<void> connection();
  asio::awaitable<bool> shake_hands();
  asio::awaitable<void> serve();
};

Agent::Impl::Impl(asio::io_context& context, AgentSettings with, TaskRenderer& renders)
    : io(context),
      settings(std::move(with)),
      renderer(renders),
      cache(settings.cache, false),
      fetcher(cache, settings.fetch),
      state([this] {
        StateSettings made = settings.state;
        made.jitter = jitter_of(identity);
        return made;
      }()),
      wake(context) {}

/// Callbacks come from other threads; what they bring is handled on the I/O thread, if the agent
/// still lives then.
void Agent::Impl::start_threads() {
  const std::weak_ptr<Impl> weak = weak_from_this();
  asio::io_context& context = io;
  const auto hand_over = [weak, &context](auto action) {
    asio::post(context, [weak, action = std::move(action)]() mutable {
      if (const auto self = weak.lock()) action(*self);
    });
  };
  crew = std::make_unique<Crew>(
      renderer,
      [hand_over](TaskEnd end) {
        hand_over([end = std::move(end)](Impl& self) mutable { self.task_ended(std::move(end)); });
      },
      [hand_over](const LeaseId& lease, double fraction) {
        hand_over([lease, fraction](Impl& self) { self.state.task_progress(lease, fraction); });
      });
  preparer = std::make_unique<Preparer>(
      renderer, fetcher,
      [hand_over](PrepareEnd end) {
        hand_over(
            [end = std::move(end)](Impl& self) mutable { self.prepare_ended(std::move(end)); });
      },
      [hand_over](double fraction) {
        hand_over([fraction](Impl& self) { self.state.prepare_progress(fraction); });
      },
      [hand_over](const wire::CacheUse& use) {
        hand_over([use](Impl& self) { self.state.cache_is(use); });
      });
}

/// Carries out what the state wants done. Called after everything that may have changed it.
void Agent::Impl::pump() {
  for (const LeaseId& lease : state.take_stops()) crew->stop(lease);
  if (state.prepare_unwanted()) preparer->stop();
  std::optional<PrepareOrder> scene = state.take_prepare();
  preparer->let_go(state.take_let_go());
  if (scene) preparer->begin(std::move(*scene));
  while (crew->wants_more()) {
    std::optional<TaskOrder> order = state.next_task();
    if (!order) break;
    crew->give(std::move(*order));
  }
  if (!stream) return;
  for (Outgoing& out : state.take_outgoing()) {
    log::debug("saying {}", wire::name_of(wire::type_of(out.message)));
    if (auto* failed = std::get_if<wire::Failed>(&out.message)) failed->log = log::recent();
    stream->send(out.message, std::move(out.body));
  }
  if ((state.finished() || giving_up) && state.is_connected() && !std::exchange(bye_said, true))
    stream->send(wire::Bye{.reason = giving_up ? "given up" : "drained"});
}

void Agent::Impl::task_ended(TaskEnd end) {
  switch (end.what) {
    case TaskEnd::What::done:
      state.task_done(end.lease, end.stats, std::move(end.bytes));
      break;
    case TaskEnd::What::stopped:
      state.task_stopped(end.lease);
      break;
    case TaskEnd::What::failed:
      log::error("a task failed: {}", end.reason);
      state.task_failed(end.lease, end.code, end.reason);
      break;
  }
  pump();
}

void Agent::Impl::prepare_ended(PrepareEnd end) {
  if (!end.code.empty()) {
    log::error("a scene could not be prepared: {}", end.reason);
    state.prepare_failed(end.code, end.reason);
  } else if (end.scene) {
    state.prepared(std::move(end.scene));
  } else {
    state.prepare_stopped();
  }
  pump();
}

void Agent::Impl::check_drain() {
  if (!state.draining()) return;
  if (!drain_began) drain_began = now();
  const Duration passed = now() - *drain_began;
  if (passed > settings.drain_wait) {
    crew->stop_all();
    giving_up = state.running() == 0 || passed > settings.drain_wait + std::chrono::seconds(1);
  }
  const bool alone = !state.is_connected() && state.running() == 0 &&
                     (state.outbox() == 0 || passed > settings.drain_alone_wait);
  if (alone || (giving_up && !state.is_connected())) exit = 0;
}

void Agent::Impl::trouble(const std::string& what) {
  if (what != last_trouble) log::warn("{}", what);
  last_trouble = what;
}

asio::awaitable<bool> Agent::Impl::shake_hands() {
  const wire::Hello hello{.token = settings.token,
                          .name = settings.name,
                          .identity = identity,
                          .threads = renderer.threads(),
                          .build_id = renderer.build_id(),
                          .version = std::string(version())};
  stream->send(hello);
  const std::optional<net::Incoming> answer = co_await stream->receive(limits::handshake_time);
  if (!answer)
    throw Error(ErrorKind::unreachable, fmt::format("{} does not answer", stream->peer()));
  if (const auto* refused = std::get_if<wire::Refused>(&answer->message)) {
    exit = AgentState::refused(*refused);
    trouble(fmt::format("refused by {}: {}", stream->peer(), refused->reason));
    co_return false;
  }
  const auto* welcome = std::get_if<wire::Welcome>(&answer->message);
  if (welcome == nullptr)
    throw Error(ErrorKind::bad_input,
                fmt::format("{} answers with {} instead of a welcome", stream->peer(),
                            wire::name_of(wire::type_of(answer->message))));
  stream->welcomed();
  log::info("connected to {} as worker {} ({}), {} threads", stream->peer(), welcome->worker,
            settings.name, renderer.threads());
  last_trouble.clear();
  state.connected(*welcome, now());
  co_return true;
}

asio::awaitable<void> Agent::Impl::serve() {
  while (!exit) {
    state.tick(now());
    pump();
    if (bye_said) {
      co_await stream->finish(std::chrono::seconds(1));
      exit = 0;
      co_return;
    }
    const Duration until_beat = std::max<Duration>(state.next_beat() - now(), Duration::zero());
    const std::optional<net::Incoming> incoming =
        co_await stream->receive(std::min(until_beat, longest_wait));
    check_drain();
    if (!incoming) continue;
    log::debug("told {}", wire::name_of(wire::type_of(incoming->message)));
    if (const auto* bye = std::get_if<wire::Bye>(&incoming->message))
      throw Error(ErrorKind::unreachable, fmt::format("the coordinator left: {}", bye->reason));
    if (const auto* rejected = std::get_if<wire::Rejected>(&incoming->message))
      log::warn("a result was rejected: {}", rejected->reason);
    if (const auto* revoke = std::get_if<wire::Revoke>(&incoming->message);
        revoke != nullptr && revoke->leases.empty())
      log::warn("the coordinator says: {}", revoke->reason);
    state.said(incoming->message, now());
  }
}

asio::awaitable<void> Agent::Impl::connection() {
  const net::StreamSettings stream_settings{.queue_bytes = queue_bytes};
  try {
    net::FramedStream made = co_await net::FramedStream::connect(
        io.get_executor(), settings.server, settings.connect_wait, stream_settings);
    stream.emplace(std::move(made));
    const bool welcomed = co_await shake_hands();
    if (welcomed) co_await serve();
  } catch (const Error& error) {
    if (!bye_said) trouble(error.what());  // the other side may close first
  }
  stream.reset();
}

asio::awaitable<int> Agent::Impl::run() {
  start_threads();
  while (true) {
    check_drain();
    if (!exit) co_await connection();
    const Duration wait = state.disconnected();
    pump();
    check_drain();
    if (exit) break;
    boost::system::error_code ignored;
    wake.expires_after(state.draining() ? std::min(wait, longest_wait) : wait);
    co_await wake.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
  }
  if (state.outbox() > 0) log::warn("{} results could not be delivered", state.outbox());
  crew->stop_all();
  preparer->stop();
  co_return *exit;
}

Agent::Agent(asio::io_context& io, AgentSettings settings, TaskRenderer& renderer)
    : impl_(std::make_shared<Impl>(io, std::move(settings), renderer)) {}

Agent::~Agent() {
  impl_->crew.reset();
  impl_->preparer.reset();
}

asio::awaitable<int> Agent::run() {
  const auto impl = impl_;
  const int code = co_await impl->run();
  co_return code;
}

void Agent::drain(const std::string& reason) {
  log::info("leaving: {}", reason);
  impl_->state.drain(reason);
  impl_->wake.cancel();
  if (impl_->crew) impl_->pump();
}

CrewStats Agent::stats() const { return impl_->crew ? impl_->crew->stats() : CrewStats{}; }

}  // namespace tessera::agent
