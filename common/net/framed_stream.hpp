#pragma once
#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/clock.hpp"
#include "common/base/limits.hpp"
#include "common/net/address.hpp"
#include "common/wire/messages.hpp"

namespace tessera::net {

struct StreamSettings {
  /// Bytes that may wait to be written, bodies included; beyond it the peer does not read, and the
  /// stream is closed.
  std::size_t queue_bytes = 8 * limits::MiB;
  /// From a frame's first byte to its last, and from the end of one chunk of a body to the end of
  /// the next: what is longer on its way is cut off.
  Duration frame_time = limits::frame_time;
  /// A single write (at most 64 KiB and what control messages wait) that takes longer closes the
  /// stream.
  Duration write_time = limits::frame_time;
};

/// One message as it came.
struct Incoming {
  wire::Message message;
  std::vector<std::byte> body;
};

/// Messages over one connection. It owns the socket; what kind of stream that is (TCP now, TLS
/// later) is seen here alone. All calls are made on the executor of the socket, which runs one
/// handler at a time. Only close() ends a receive() early: cancellation signals are not looked at.
class FramedStream {
 public:
  /// Over an accepted or connected socket. Turns Nagle's algorithm off.
  explicit FramedStream(boost::asio::ip::tcp::socket socket, StreamSettings settings = {});
  /// Closes.
  ~FramedStream();
  FramedStream(FramedStream&&) noexcept;
  FramedStream& operator=(FramedStream&&) = delete;

  /// Resolves and connects. Throws Error{unreachable} that names the address.
  static boost::asio::awaitable<FramedStream> connect(boost::asio::any_io_executor executor,
                                                      Address address, Duration wait,
                                                      StreamSettings settings = {});

  /// From the next message on the full limits hold (before it, 4 KiB of header and no body).
  void welcomed();
  /// Called for every piece of bytes that comes: a sign of life. Only while a receive() waits are
  /// bytes taken in.
  void on_bytes(std::function<void()> hook);

  /// The next message; nullopt after `wait` without a whole one (what has come of it is kept). One
  /// receive() at a time. Throws wire::FrameError or Error{bad_input} for bytes that are no message
  /// of this protocol, Error{unreachable} when the connection has ended (what() says how), was
  /// closed here, or half a message was followed by silence.
  boost::asio::awaitable<std::optional<Incoming>> receive(Duration wait);

  /// Queues; never blocks, never throws. Messages without a body go ahead of bodies and between
  /// their chunks (but `bye` goes last). After close() it does nothing. A queue that overflows
  /// closes the stream; the next receive() says so.
  void send(const wire::Message& message,
            std::shared_ptr<const std::vector<std::byte>> body = nullptr);
  /// Waits until everything queued is written. False after `wait`, or when the stream has closed.
  boost::asio::awaitable<bool> flush(Duration wait);
  /// A clean end: flushes, says that nothing more comes, waits until the peer has closed too (what
  /// it still sends is thrown away), but at most `wait`, and closes. No receive() may be under way.
  boost::asio::awaitable<void> finish(Duration wait);
  /// Bytes queued and not yet written.
  [[nodiscard]] std::size_t queued() const;

  /// Ends the connection at once; the first reason is kept and is what receive() then throws.
  void close(const std::string& reason);
  [[nodiscard]] bool is_open() const;
  /// "address:port" of the other side, and of this side; for logs and for blob_url.
  [[nodiscard]] const std::string& peer() const;
  [[nodiscard]] const std::string& local() const;

 private:
  struct Connection;
  std::shared_ptr<Connection> connection_;
};

/// Opens a listener. Throws Error{failed} that names the address and why.
boost::asio::ip::tcp::acceptor listen(const boost::asio::any_io_executor& executor,
                                      const Address& address);

}  // namespace tessera::net
