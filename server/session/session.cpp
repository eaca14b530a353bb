#include "server/session/session.hpp"

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/use_awaitable.hpp>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "common/base/names.hpp"
#include "server/session/handshake.hpp"

namespace tessera::server {

namespace {

constexpr Duration last_word_time = std::chrono::seconds(1);
constexpr Duration receive_time =
    std::chrono::minutes(1);  // the scheduler decides who is silent, not this
constexpr Duration held_step = std::chrono::milliseconds(500);

/// True for messages that a worker may send after hello.
bool is_workers(const wire::Message& message) {
  return std::holds_alternative<wire::Preparing>(message) ||
         std::holds_alternative<wire::Ready>(message) ||
         std::holds_alternative<wire::Progress>(message) ||
         std::holds_alternative<wire::Failed>(message) ||
         std::holds_alternative<wire::Drain>(message);
}

}  // namespace

Session::Session(boost::asio::ip::tcp::socket socket, Coordinator& coordinator,
                 const SessionSettings& settings, Spawn spawn)
    : held_timer_(socket.get_executor()),
      stream_(std::move(socket)),
      coordinator_(coordinator),
      settings_(settings),
      spawn_(std::move(spawn)),
      who_(stream_.peer()) {}

boost::asio::awaitable<void> Session::run(std::shared_ptr<Session> self, bool full) {
  try {
    if (full) {
      self->end_with(wire::Refused{"full", "the coordinator has as many connections as it takes"},
                     "too many connections");
    } else if (co_await self->shake_hands()) {
      co_await self->listen_to_worker();
    }
  } catch (const wire::FrameError& error) {
    log::warn("{}: {}", self->who_, error.what());
    if (!self->ending_) self->end_with(refusal_of(error), error.what());
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::unreachable) {
      if (!self->ending_) log::info("{}: {}", self->who_, error.what());
      if (!self->ending_) self->stream_.close(error.what());
    } else {
      log::warn("{}: {}", self->who_, error.what());
      if (!self->ending_) self->end_with(wire::Refused{"protocol", error.what()}, error.what());
    }
  } catch (const std::exception& error) {
    log::error("{}: {}", self->who_, error.what());
    if (!self->ending_) self->end_with(wire::Bye{"an error within the coordinator"}, error.what());
  }
  self->leave();
}

boost::asio::awaitable<bool> Session::shake_hands() {
  std::optional<net::Incoming> first = co_await stream_.receive(settings_.handshake_time);
  if (ending_) co_return false;
  if (!first) throw Error(ErrorKind::bad_input, "nothing that is a hello came in time");
  const auto* hello = std::get_if<wire::Hello>(&first->message);
  if (!hello) throw Error(ErrorKind::bad_input, "expected hello as the first message");
  if (const auto refused = check_hello(*hello, settings_.token)) {
    log::warn("{}: refused ({}): {}", who_, refused->code, refused->reason);
    end_with(*refused, refused->reason);
    co_return false;
  }
  wire::Welcome welcome;
  welcome.blob_url = blob_url_for(settings_.blob_url, stream_.local(), settings_.http_port);
  welcome.blob_token = settings_.blob_token;
  welcome.epoch = coordinator_.epoch();
  welcome.heartbeat_ms = static_cast<int>(
      std::chrono::duration_cast<std::chrono::milliseconds>(settings_.heartbeat).count());
  who_ += " (" + hello->name + ")";
  const WorkerInfo info{hello->name, hello->identity, hello->threads, hello->build_id};
  // The coordinator may grant leases before worker_joined returns: they wait behind the welcome.
  joining_.emplace();
  worker_ = coordinator_.worker_joined(info, shared_from_this());
  welcome.worker = *worker_;
  stream_.welcomed();
  stream_.send(welcome);
  for (const wire::Message& message : *joining_) stream_.send(message);
  joining_.reset();
  stream_.on_bytes([this] {
    if (worker_) coordinator_.worker_heard(*worker_);
  });
  log::info("{}: worker {} joined with {} threads, version {}", who_, *worker_, hello->threads,
            excerpt(hello->version));
  co_return true;
}

boost::asio::awaitable<void> Session::listen_to_worker() {
  while (!clean_ && !ending_) {
    if (held_) co_await wait_while_held();
    std::optional<net::Incoming> incoming = co_await stream_.receive(receive_time);
    if (incoming && !ending_) take(std::move(*incoming));
  }
  if (clean_ && !ending_) stream_.close("the worker said bye");
}

boost::asio::awaitable<void> Session::wait_while_held() {
  while (held_ && !ending_ && worker_) {
    coordinator_.excuse_worker(*worker_);  // that nothing is read is not its silence
    held_timer_.expires_after(held_step);
    co_await held_timer_.async_wait(boost::asio::as_tuple(boost::asio::use_awaitable));
  }
}

void Session::take(net::Incoming incoming) {
  if (auto* result = std::get_if<wire::Result>(&incoming.message)) {
    coordinator_.worker_result(*worker_, *result, std::move(incoming.body));
  } else if (const auto* bye = std::get_if<wire::Bye>(&incoming.message)) {
    log::info("{}: bye: {}", who_, excerpt(bye->reason, 400));
    clean_ = true;
  } else if (is_workers(incoming.message)) {
    coordinator_.worker_said(*worker_, std::move(incoming.message));
  } else {
    throw Error(ErrorKind::bad_input, "a message that a worker does not send after hello");
  }
}

void Session::send(wire::Message message) {
  if (ending_) return;
  if (joining_) {
    joining_->push_back(std::move(message));
  } else {
    stream_.send(message);
  }
}

void Session::close(std::string reason) {
  if (ending_) return;
  log::info("{}: closed: {}", who_, reason);
  end_with(wire::Bye{reason}, reason);
}

void Session::stop(const std::string& reason) {
  clean_ = true;
  if (!ending_) end_with(wire::Bye{reason}, reason);
}

void Session::hold(bool held) {
  held_ = held;
  held_timer_.cancel();
}

void Session::end_with(const wire::Message& last, const std::string& reason) {
  ending_ = true;
  held_timer_.cancel();
  stream_.send(last);
  spawn_(closing(shared_from_this(), reason));
}

boost::asio::awaitable<void> Session::closing(std::shared_ptr<Session> self, std::string reason) {
  co_await self->stream_.flush(last_word_time);
  self->stream_.close(reason);
}

void Session::leave() {
  if (!worker_) return;
  const WorkerId worker = *worker_;
  worker_.reset();
  coordinator_.worker_left(worker, clean_);
}

}  // namespace tessera::server
