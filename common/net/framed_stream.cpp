#include "common/net/framed_stream.hpp"

#include <fmt/format.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <boost/asio/bind_cancellation_slot.hpp>
#include <boost/asio/cancellation_signal.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <deque>
#include <span>
#include <utility>

#include "common/base/error.hpp"
#include "common/wire/codec.hpp"
#include "common/wire/framing.hpp"

namespace tessera::net {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;
using Steady = std::chrono::steady_clock;

namespace {
using Body = std::shared_ptr<const std::vector<std::byte>>;

std::string text_of(const tcp::endpoint& endpoint) {
  return Address{.host = endpoint.address().to_string(), .port = endpoint.port()}.text();
}

/// A peer whose machine is gone answers nothing; the kernel then gives up after this long with
/// bytes under way.
void set_user_timeout(tcp::socket& socket, Duration wait) {
  const auto ms =
      static_cast<unsigned>(std::chrono::duration_cast<std::chrono::milliseconds>(wait).count());
  ::setsockopt(socket.native_handle(), IPPROTO_TCP, 18 /* TCP_USER_TIMEOUT */, &ms, sizeof ms);
}

/// A message with a body, on its way out.
struct Bulk {
  wire::EncodedMessage message;
  Body body;
  std::size_t sent = 0;
  bool begun = false;
};
}  // namespace

/// Kept alive by the handlers of what is under way, so that it may outlive the FramedStream until
/// they have ended.
struct FramedStream::Connection : std::enable_shared_from_this<Connection> {
  Connection(tcp::socket taken, StreamSettings with)
      : socket(std::move(taken)),
        settings(with),
        read_timer(socket.get_executor()),
        write_timer(socket.get_executor()),
        flush_timer(socket.get_executor()) {
    error_code ignored;
    socket.set_option(tcp::no_delay(true), ignored);
    set_user_timeout(socket, settings.write_time);
    peer = text_of(socket.remote_endpoint(ignored));
    local = text_of(socket.local_endpoint(ignored));
    flush_timer.expires_at(asio::steady_timer::time_point::max());
  }

  // ---- reading ----
  tcp::socket socket;
  StreamSettings settings;
  asio::steady_timer read_timer;
  wire::FrameReader reader;
  std::function<void()> hook;
  std::array<std::byte, limits::wire_chunk> buffer{};
  std::span<const std::byte> unread;              ///< within `buffer`
  std::optional<Steady::time_point> frame_since;  ///< when the frame that is half here began
  std::uint64_t frames_then = 0;
  std::uint64_t reads = 0;

  std::optional<Incoming> next_here();
  void note_progress();
  asio::awaitable<bool> fill(Steady::time_point deadline);

  // ---- writing ----
  asio::steady_timer write_timer;
  asio::steady_timer flush_timer;  ///< cancelled when all is written or the stream closed
  std::deque<wire::EncodedMessage> control;
  std::deque<Bulk> bulk;
  std::string heads;  ///< what is being written: control frames, then the head of a chunk
  wire::OutFrame chunk;
  Body chunk_body;  ///< keeps the chunk's bytes
  std::size_t queued = 0;
  bool writing = false;

  void enqueue(const wire::Message& message, Body body);
  void write();
  void written(error_code error, std::size_t taken);

  // ---- the end ----
  std::string end;  ///< why it closed; empty while open
  std::string peer, local;
  void close(const std::string& reason);
  [[noreturn]] void throw_end() const { throw Error(ErrorKind::unreachable, end); }
};

void FramedStream::Connection::close(const std::string& reason) {
  if (!end.empty()) return;
  end = reason.empty() ? "the connection was closed" : reason;
  error_code ignored;
  socket.close(ignored);
  read_timer.cancel();
  write_timer.cancel();
  flush_timer.cancel();
  control.clear();
  bulk.clear();
  queued = 0;
}

std::optional<Incoming> FramedStream::Connection::next_here() {
  std::optional<wire::Frame> frame = reader.read(unread);
  if (!frame) return std::nullopt;
  Incoming incoming{.message = wire::decode(frame->type, frame->header), .body = {}};
  incoming.body = std::move(frame->body);
  return incoming;
}

void FramedStream::Connection::note_progress() {
  if (!reader.in_message()) {
    frame_since.reset();
  } else if (!frame_since || frames_then != reader.frames()) {
    frame_since = Steady::now();
  }
  frames_then = reader.frames();
}

/// Reads some bytes into the buffer; false at the deadline.
asio::awaitable<bool> FramedStream::Connection::fill(Steady::time_point deadline) {
  const auto self = shared_from_this();
  // The signal ends this one read alone, and none that comes after it.
  const auto signal = std::make_shared<asio::cancellation_signal>();
  const std::uint64_t number = ++reads;
  read_timer.expires_at(deadline);
  read_timer.async_wait([self, signal, number](error_code error) {
    if (!error && self->reads == number) signal->emit(asio::cancellation_type::all);
  });
  error_code error;
  auto token = asio::bind_cancellation_slot(signal->slot(),
                                            asio::redirect_error(asio::use_awaitable, error));
  const auto target = asio::buffer(buffer.data(), buffer.size());
  const std::size_t got = co_await socket.async_read_some(target, token);
  ++reads;
  read_timer.cancel();
  if (!end.empty()) throw_end();
  if (got > 0) {
    unread = std::span<const std::byte>(buffer).first(got);
    if (hook) hook();
    co_return true;
  }
  if (error == asio::error::operation_aborted) co_return false;
  close(error == asio::error::eof
            ? fmt::format("{} closed the connection", peer)
            : fmt::format("the connection to {} broke: {}", peer, error.message()));
  throw_end();
}

void FramedStream::Connection::enqueue(const wire::Message& message, Body body) {
  const bool has_body = body && !body->empty();
  wire::EncodedMessage encoded = wire::encode(message);
  queued +=
      wire::prefix_bytes + wire::crc_bytes + encoded.header.size() + (has_body ? body->size() : 0);
  const bool last = std::holds_alternative<wire::Bye>(message);
  if (has_body || (last && !bulk.empty())) {
    bulk.push_back({.message = std::move(encoded), .body = std::move(body)});
  } else {
    control.push_back(std::move(encoded));
  }
  if (queued > settings.queue_bytes) {
    close(fmt::format("{} does not read: more than {} bytes wait for it", peer,
                      settings.queue_bytes));
    return;
  }
  if (!writing) write();
}

void FramedStream::Connection::write() {
  heads.clear();
  std::size_t taken = 0;
  while (!control.empty() && heads.size() < limits::wire_chunk) {
    const wire::OutFrame out = wire::first_frame(control.front().type, control.front().header, {});
    heads += out.head;
    for (const std::byte byte : out.crc) heads.push_back(static_cast<char>(byte));
    taken += out.size();
    control.pop_front();
  }
  chunk = {};
  chunk_body.reset();
  if (control.empty() && !bulk.empty()) {
    Bulk& first = bulk.front();
    chunk_body = first.body;
    const std::span<const std::byte> rest =
        chunk_body ? std::span(*chunk_body).subspan(first.sent) : std::span<const std::byte>{};
    chunk = first.begun ? wire::chunk_frame(rest)
                        : wire::first_frame(first.message.type, first.message.header, rest);
    taken += first.begun ? chunk.body.size() : chunk.size();
    heads += chunk.head;
    first.begun = true;
    first.sent += chunk.body.size();
    if (!chunk_body || first.sent == chunk_body->size()) bulk.pop_front();
  }
  if (heads.empty()) {
    flush_timer.cancel();
    return;
  }
  writing = true;
  const auto self = shared_from_this();
  write_timer.expires_after(settings.write_time);
  write_timer.async_wait([self](error_code error) {
    if (error || !self->writing || self->write_timer.expiry() > Steady::now()) return;
    self->close(fmt::format("{} does not read: a write took longer than {} s", self->peer,
                            seconds(self->settings.write_time)));
  });
  const bool with_chunk = !chunk.head.empty();
  const std::array<asio::const_buffer, 3> buffers = {
      asio::buffer(heads), asio::buffer(chunk.body.data(), chunk.body.size()),
      asio::buffer(chunk.crc.data(), with_chunk ? chunk.crc.size() : 0)};
  asio::async_write(socket, buffers,
                    [self, taken](error_code error, std::size_t) { self->written(error, taken); });
}

void FramedStream::Connection::written(error_code error, std::size_t taken) {
  writing = false;
  if (!end.empty()) return;
  if (error) {
    close(fmt::format("the connection to {} broke: {}", peer, error.message()));
    return;
  }
  queued -= std::min(queued, taken);
  write();
  if (!writing) write_timer.cancel();
}

// ---- the class ----
FramedStream::FramedStream(tcp::socket socket, StreamSettings settings)
    : connection_(std::make_shared<Connection>(std::move(socket), settings)) {}
FramedStream::~FramedStream() {
  if (connection_) close("the stream was given up");
}
FramedStream::FramedStream(FramedStream&&) noexcept = default;

void FramedStream::welcomed() { connection_->reader.welcomed(); }
void FramedStream::on_bytes(std::function<void()> hook) { connection_->hook = std::move(hook); }
std::size_t FramedStream::queued() const { return connection_->queued; }
bool FramedStream::is_open() const { return connection_->end.empty(); }
void FramedStream::close(const std::string& reason) { connection_->close(reason); }
const std::string& FramedStream::peer() const { return connection_->peer; }
const std::string& FramedStream::local() const { return connection_->local; }

asio::awaitable<std::optional<Incoming>> FramedStream::receive(Duration wait) {
  const auto connection = connection_;  // the stream may be destroyed meanwhile
  const Steady::time_point deadline = Steady::now() + wait;
  while (true) {
    std::optional<Incoming> incoming = connection->next_here();
    connection->note_progress();
    if (incoming) co_return incoming;
    if (!connection->end.empty()) connection->throw_end();
    const auto frame_end = connection->frame_since
                               ? *connection->frame_since + connection->settings.frame_time
                               : Steady::time_point::max();
    const bool filled = co_await connection->fill(std::min(deadline, frame_end));
    if (filled) continue;
    if (Steady::now() >= frame_end)
      connection->close(
          fmt::format("{} sent part of a frame, and the rest did not come within {} s",
                      connection->peer, seconds(connection->settings.frame_time)));
    if (!connection->end.empty()) connection->throw_end();
    if (Steady::now() >= deadline) co_return std::nullopt;
  }
}

void FramedStream::send(const wire::Message& message,
                        std::shared_ptr<const std::vector<std::byte>> body) {
  if (!is_open()) return;
  const auto* revoke = std::get_if<wire::Revoke>(&message);
  if (revoke == nullptr || revoke->leases.size() <= wire::leases_per_message) {
    connection_->enqueue(message, std::move(body));
    return;
  }
  for (std::size_t at = 0; at < revoke->leases.size() && is_open();
       at += wire::leases_per_message) {
    const std::size_t count = std::min(wire::leases_per_message, revoke->leases.size() - at);
    const auto begin = revoke->leases.begin() + static_cast<std::ptrdiff_t>(at);
    connection_->enqueue(wire::Revoke{.leases = {begin, begin + static_cast<std::ptrdiff_t>(count)},
                                      .reason = revoke->reason},
                         nullptr);
  }
}

asio::awaitable<bool> FramedStream::flush(Duration wait) {
  const auto connection = connection_;
  const Steady::time_point deadline = Steady::now() + wait;
  while (connection->end.empty() && (connection->writing || connection->queued > 0)) {
    if (Steady::now() >= deadline) co_return false;
    connection->flush_timer.expires_at(deadline);
    error_code ignored;
    co_await connection->flush_timer.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
  }
  co_return connection->end.empty();
}

asio::awaitable<void> FramedStream::finish(Duration wait) {
  const auto connection = connection_;
  const Steady::time_point deadline = Steady::now() + wait;
  const bool flushed = co_await flush(wait);
  if (!flushed) {
    connection->close("the peer did not take the last messages");
    co_return;
  }
  // Closing with unread bytes here would make the kernel throw away what the peer has not read yet.
  error_code ignored;
  connection->socket.shutdown(tcp::socket::shutdown_send, ignored);
  try {
    while (Steady::now() < deadline) co_await connection->fill(deadline);
  } catch (const Error&) {  // the peer has closed too: that is what was waited for
  }
  connection->close("the connection was closed");
}

}  // namespace tessera::net
