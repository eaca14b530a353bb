#include "server/http/connection.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/buffer_body.hpp>
#include <boost/beast/http/error.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <cctype>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "server/http/response_writer.hpp"

namespace tessera::server {

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;

using Parser = http::request_parser<http::buffer_body>;

constexpr std::size_t leftover_most =
    64 * limits::KiB;  ///< of an unread body that is worth reading to keep the connection
constexpr std::size_t linger_most = 8 * limits::MiB;
constexpr std::chrono::seconds linger_time{2};

/// The body that one parser is in the middle of.
class ConnectionBody : public BodyReader {
 public:
  ConnectionBody(beast::tcp_stream& stream, beast::flat_buffer& buffer, Parser& parser,
                 const HttpSettings& settings)
      : stream_(stream), buffer_(buffer), parser_(parser), settings_(settings) {
    const auto expect = parser.get().find(http::field::expect);
    continue_due_ = expect != parser.get().end() && beast::iequals(expect->value(), "100-continue");
  }

  asio::awaitable<std::size_t> read(std::span<std::byte> into) override {
    if (broken_) fail();
    if (parser_.is_done() || into.empty()) co_return 0;
    if (continue_due_) {
      continue_due_ = false;
      constexpr std::string_view go_on = "HTTP/1.1 100 Continue\r\n\r\n";
      if (!co_await write_all(stream_, asio::buffer(go_on), settings_.write_time)) fail();
    }
    auto& body = parser_.get().body();
    body.data = into.data();
    body.size = into.size();
    body.more = true;
    stream_.expires_after(settings_.idle_time);
    boost::system::error_code error;
    co_await http::async_read(stream_, buffer_, parser_,
                              asio::redirect_error(asio::use_awaitable, error));
    const std::size_t count = into.size() - body.size;
    broken_ = error && error != http::error::need_buffer;
    if (broken_ && count == 0) fail();
    co_return count;  // what came before it broke off is told of first
  }

  [[nodiscard]] std::optional<std::uint64_t> length() const override {
    const auto length = parser_.content_length();
    if (!length) return std::nullopt;
    return *length;
  }

  /// True if the next request can follow: the body is read to its end, or what is left is little
  /// and was read now.
  asio::awaitable<bool> read_leftover() {
    if (parser_.is_done()) co_return true;
    if (broken_ || continue_due_ || length().value_or(leftover_most + 1) > leftover_most)
      co_return false;
    std::vector<std::byte> scratch(leftover_most);
    boost::system::error_code error;
    while (!parser_.is_done() && !error) {
      auto& body = parser_.get().body();
      body.data = scratch.data();
      body.size = scratch.size();
      stream_.expires_after(linger_time);
      co_await http::async_read(stream_, buffer_, parser_,
                                asio::redirect_error(asio::use_awaitable, error));
      if (error == http::error::need_buffer) error = {};
    }
    co_return parser_.is_done();
  }

 private:
  [[noreturn]] static void fail() {
    throw Error(ErrorKind::bad_input, "the request's body broke off, or was too slow");
  }

  beast::tcp_stream& stream_;
  beast::flat_buffer& buffer_;
  Parser& parser_;
  const HttpSettings& settings_;
  bool continue_due_ = false;
  bool broken_ = false;
};

std::string lower(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return out;
}

HttpRequest request_from(const Parser& parser, BodyReader& body) {
  HttpRequest request;
  const auto& message = parser.get();
  request.method = std::string(message.method_string());
  request.target = std::string(message.target());
  for (const auto& field : message)
    request.fields.emplace_back(lower(field.name_string()), std::string(field.value()));
  request.body = &body;
  return request;
}

/// The answer to what could not be read as a request; nothing if the peer is merely gone or silent.
std::optional<HttpResponse> refusal_of(const boost::system::error_code& error) {
  if (error == http::error::header_limit || error == http::error::buffer_overflow)
    return problem(431,
                   fmt::format("the request's header has more than {} bytes", limits::http_header));
  if (error == http::error::end_of_stream || error == http::error::partial_message)
    return std::nullopt;
  if (error.category() == http::make_error_code(http::error::bad_method).category())
    return problem(400, fmt::format("this is no HTTP/1.1 request: {}", error.message()));
  return std::nullopt;
}

/// Two readings of one message must not be possible: what stands before us might take the other
/// (RFC 9112, 6.1).
bool length_is_ambiguous(const Parser& parser) {
  const auto& message = parser.get();
  const auto coding = message.find(http::field::transfer_encoding);
  if (coding == message.end()) return false;
  return message.count(http::field::transfer_encoding) > 1 ||
         !beast::iequals(coding->value(), "chunked") ||
         message.count(http::field::content_length) > 0;
}

/// Ends the sending side, then reads for a moment what the peer still sends: were it left unread,
/// the peer's system would throw away the answer together with the connection.
asio::awaitable<void> linger(beast::tcp_stream& stream) {
  boost::system::error_code error;
  stream.socket().shutdown(asio::ip::tcp::socket::shutdown_send, error);
  if (error) co_return;
  std::vector<std::byte> scratch(64 * limits::KiB);
  stream.expires_after(linger_time);
  std::size_t total = 0;
  while (!error && total < linger_most)
    total += co_await stream.async_read_some(asio::buffer(scratch),
                                             asio::redirect_error(asio::use_awaitable, error));
}

/// One request and its answer. True if another may follow.
asio::awaitable<bool> serve_one(beast::tcp_stream& stream, beast::flat_buffer& buffer, Api& api,
                                asio::thread_pool& files, const HttpSettings& settings) {
  Parser parser;
  parser.header_limit(limits::http_header);
  parser.body_limit(boost::none);  // each handler has its own
  stream.expires_after(settings.idle_time);
  boost::system::error_code error;
  co_await http::async_read_header(stream, buffer, parser,
                                   asio::redirect_error(asio::use_awaitable, error));
  ResponseWriter writer(stream, files, settings.write_time);
  if (error) {
    if (auto refusal = refusal_of(error)) {
      co_await writer.write(*refusal, false, false);
      co_await linger(stream);
    }
    co_return false;
  }
  if (length_is_ambiguous(parser)) {
    const HttpResponse refusal =
        problem(400, "expected Content-Length, or Transfer-Encoding: chunked, and not both");
    co_await writer.write(refusal, false, false);
    co_await linger(stream);
    co_return false;
  }
  ConnectionBody body(stream, buffer, parser, settings);
  HttpRequest request = request_from(parser, body);
  const HttpResponse response = co_await api.handle(request);
  const bool whole = co_await body.read_leftover();
  const bool keep = whole && parser.keep_alive();
  const bool sent = co_await writer.write(response, request.method == "HEAD", keep);
  if (sent && !keep) co_await linger(stream);
  co_return sent&& keep&& response.length().has_value();
}

}  // namespace

asio::awaitable<void> serve_connection(asio::ip::tcp::socket socket, Api& api,
                                       asio::thread_pool& files, const HttpSettings& settings) {
  boost::system::error_code error;
  socket.set_option(asio::ip::tcp::no_delay(true), error);
  beast::tcp_stream stream(std::move(socket));
  beast::flat_buffer buffer(limits::http_header + 128 * limits::KiB);
  while (co_await serve_one(stream, buffer, api, files, settings)) {
  }
}

}  // namespace tessera::server
