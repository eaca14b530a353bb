#include "common/net/http_client.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/buffer_body.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/serializer.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/http/write.hpp>
#include <fstream>

#include "common/base/build_info.hpp"
#include "common/base/error.hpp"
#include "common/net/address.hpp"
#include "common/net/http_text.hpp"

namespace tessera::net {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::ip::tcp;
using boost::system::error_code;
using Sink = std::function<void(std::span<const std::byte>)>;
using Parser = http::response_parser<http::buffer_body>;

namespace {
constexpr std::size_t piece_bytes = 64 * limits::KiB;

/// A connection and what has been read of it beyond the last response.
struct Wire {
  explicit Wire(const asio::any_io_executor& executor) : stream(executor), resolver(executor) {}
  beast::tcp_stream stream;
  tcp::resolver resolver;
  beast::flat_buffer buffer;
  bool used = false;      ///< a response has come over it before
  bool answered = false;  ///< of the present request, something has come
  bool cancelled = false;
};

bool repeatable(std::string_view method) { return method != "POST" && method != "PATCH"; }
}  // namespace

struct HttpClient::Impl {
  asio::any_io_executor executor;
  std::string base_url, prefix, host_header, token;
  Address address;
  std::shared_ptr<Wire> kept;                  ///< for the next request
  std::vector<std::weak_ptr<Wire>> under_way;  ///< for cancel()

  [[noreturn]] void fail(const Wire& wire, const error_code& error) const;
  std::shared_ptr<Wire> new_wire();
  asio::awaitable<void> connect(std::shared_ptr<Wire> wire, Duration time);
  asio::awaitable<void> write(std::shared_ptr<Wire> wire, const HttpRequest& request);
  asio::awaitable<void> write_file(std::shared_ptr<Wire> wire,
                                   http::request<http::buffer_body>& message,
                                   const HttpRequest& request);
  asio::awaitable<HttpResponse> read(std::shared_ptr<Wire> wire, const HttpRequest& request,
                                     const Sink* sink);
  asio::awaitable<void> read_body(std::shared_ptr<Wire> wire, Parser& parser, Duration time,
                                  const Sink& sink);
  asio::awaitable<HttpResponse> once(std::shared_ptr<Wire> wire, const HttpRequest& request,
                                     const Sink* sink);
  asio::awaitable<HttpResponse> run(HttpRequest request, const Sink* sink);
  template <class Message>
  void set_fields(Message& message, const HttpRequest& request) const;
};

void HttpClient::Impl::fail(const Wire& wire, const error_code& error) const {
  if (wire.cancelled) throw Error(ErrorKind::failed, "cancelled");
  std::string why = error.message();
  if (error == beast::error::timeout) why = "it does not answer in time";
  if (error == http::error::end_of_stream || error == http::error::partial_message ||
      error == asio::error::eof)
    why = "it closed the connection";
  if (error == http::error::body_limit)
    throw Error(ErrorKind::too_large,
                fmt::format("{} sends a larger answer than is taken", address.text()));
  if (error.category() == error_code(http::error::bad_version).category() &&
      error != http::error::end_of_stream && error != http::error::partial_message)
    throw Error(ErrorKind::failed,
                fmt::format("{} does not speak HTTP/1.1 as it should: {}", address.text(), why));
  throw Error(ErrorKind::unreachable,
              fmt::format("cannot reach the server at {}: {}", address.text(), why));
}

std::shared_ptr<Wire> HttpClient::Impl::new_wire() {
  auto wire = std::make_shared<Wire>(executor);
  std::erase_if(under_way, [](const std::weak_ptr<Wire>& old) { return old.expired(); });
  under_way.push_back(wire);
  return wire;
}

asio::awaitable<void> HttpClient::Impl::connect(std::shared_ptr<Wire> wire, Duration time) {
  error_code error;
  const std::string port = std::to_string(address.port);
  auto token_of = asio::redirect_error(asio::use_awaitable, error);
  const tcp::resolver::results_type found =
      co_await wire->resolver.async_resolve(address.host, port, token_of);
  if (error || wire->cancelled) fail(*wire, error);
  wire->stream.expires_after(time);
  co_await wire->stream.async_connect(found, token_of);
  if (error || wire->cancelled) fail(*wire, error);
  wire->stream.socket().set_option(tcp::no_delay(true), error);
}

template <class Message>
void HttpClient::Impl::set_fields(Message& message, const HttpRequest& request) const {
  message.version(11);
  message.method_string(request.method);
  message.target(prefix + request.target);
  message.set(http::field::host, host_header);
  message.set(http::field::user_agent, fmt::format("tessera/{}", version()));
  if (!token.empty()) message.set(http::field::authorization, "Bearer " + token);
  for (const auto& [name, value] : request.headers) message.set(name, value);
}

asio::awaitable<void> HttpClient::Impl::write_file(std::shared_ptr<Wire> wire,
                                                   http::request<http::buffer_body>& message,
                                                   const HttpRequest& request) {
  const FileRange& range = *request.file;
  std::ifstream in(range.file, std::ios::binary);
  in.seekg(static_cast<std::streamoff>(range.offset));
  if (!in) throw Error(ErrorKind::failed, "cannot read the file", {.file = range.file.string()});
  error_code error;
  auto token_of = asio::redirect_error(asio::use_awaitable, error);
  http::request_serializer<http::buffer_body> serializer(message);
  std::vector<char> piece(piece_bytes);
  std::uint64_t left = range.size;
  message.body().data = nullptr;
  message.body().size = 0;
  message.body().more = left > 0;
  wire->stream.expires_after(request.time);
  co_await http::async_write_header(wire->stream, serializer, token_of);
  while (!error && left > 0) {
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(left, piece.size()));
    in.read(piece.data(), static_cast<std::streamsize>(count));
    if (in.gcount() != static_cast<std::streamsize>(count))
      throw Error(ErrorKind::failed, "the file became shorter while it was sent",
                  {.file = range.file.string()});
    left -= count;
    message.body().data = piece.data();
    message.body().size = count;
    message.body().more = left > 0;
    wire->stream.expires_after(request.time);
    co_await http::async_write(wire->stream, serializer, token_of);
    if (error == http::error::need_buffer) error = {};
    if (!error && range.sent) range.sent(range.size - left);
  }
  // A server that refuses may answer and close before it has taken the whole body: its answer says
  // more than this error.
  if (error && error != asio::error::broken_pipe && error != asio::error::connection_reset)
    fail(*wire, error);
}

asio::awaitable<void> HttpClient::Impl::write(std::shared_ptr<Wire> wire,
                                              const HttpRequest& request) {
  if (request.file) {
    http::request<http::buffer_body> message;
    set_fields(message, request);
    message.content_length(request.file->size);
    co_await write_file(wire, message, request);
    co_return;
  }
  http::request<http::string_body> message;
  set_fields(message, request);
  message.body() = request.body;
  if (!request.body.empty() || request.method == "POST" || request.method == "PUT" ||
      request.method == "PATCH")
    message.content_length(request.body.size());
  error_code error;
  auto token_of = asio::redirect_error(asio::use_awaitable, error);
  wire->stream.expires_after(request.time);
  co_await http::async_write(wire->stream, message, token_of);
  if (error && error != asio::error::broken_pipe && error != asio::error::connection_reset)
    fail(*wire, error);
}

asio::awaitable<void> HttpClient::Impl::read_body(std::shared_ptr<Wire> wire, Parser& parser,
                                                  Duration time, const Sink& sink) {
  std::vector<std::byte> piece(piece_bytes);
  error_code error;
  auto token_of = asio::redirect_error(asio::use_awaitable, error);
  while (!parser.is_done()) {
    parser.get().body().data = piece.data();
    parser.get().body().size = piece.size();
    wire->stream.expires_after(time);
    co_await http::async_read_some(wire->stream, wire->buffer, parser, token_of);
    if (error == http::error::need_buffer) error = {};
    if (error || wire->cancelled) fail(*wire, error);
    const std::size_t got = piece.size() - parser.get().body().size;
    if (got > 0) sink(std::span<const std::byte>(piece).first(got));
    if (wire->cancelled) fail(*wire, error);
  }
}

asio::awaitable<HttpResponse> HttpClient::Impl::read(std::shared_ptr<Wire> wire,
                                                     const HttpRequest& request, const Sink* sink) {
  Parser parser;
  parser.header_limit(limits::http_header);
  parser.body_limit(boost::none);
  if (request.method == "HEAD") parser.skip(true);
  error_code error;
  auto token_of = asio::redirect_error(asio::use_awaitable, error);
  wire->stream.expires_after(request.time);
  co_await http::async_read_header(wire->stream, wire->buffer, parser, token_of);
  wire->answered = parser.got_some();
  if (error || wire->cancelled) fail(*wire, error);
  HttpResponse response;
  response.status = parser.get().result_int();
  for (const auto& field : parser.get())
    response.headers.emplace_back(std::string(field.name_string()), std::string(field.value()));
  if (request.head) request.head(response);
  const Sink to_memory = [&response, &request](std::span<const std::byte> bytes) {
    if (response.body.size() + bytes.size() > request.response_most)
      throw Error(ErrorKind::too_large,
                  fmt::format("the answer to {} {} has more than {} bytes", request.method,
                              request.target, request.response_most));
    const std::size_t at = response.body.size();
    response.body.resize(at + bytes.size());
    std::copy(
        bytes.begin(), bytes.end(),
        std::as_writable_bytes(std::span(response.body)).begin() + static_cast<std::ptrdiff_t>(at));
  };
  const bool to_sink = sink != nullptr && response.status < 400;
  co_await read_body(wire, parser, request.time, to_sink ? *sink : to_memory);
  wire->used = true;
  if (!parser.keep_alive()) wire->stream.close();
  co_return response;
}

asio::awaitable<HttpResponse> HttpClient::Impl::once(std::shared_ptr<Wire> wire,
                                                     const HttpRequest& request, const Sink* sink) {
  wire->answered = false;
  if (!wire->stream.socket().is_open()) co_await connect(wire, request.time);
  co_await write(wire, request);
  HttpResponse response = co_await read(wire, request, sink);
  co_return response;
}

asio::awaitable<HttpResponse> HttpClient::Impl::run(HttpRequest request, const Sink* sink) {
  // A kept connection may have been closed by the server meanwhile. Then a request that may be
  // repeated is, on a new one; the others always go over a new one, as nobody could say whether
  // they were carried out. Of a file, who sends it knows better how it goes on.
  std::shared_ptr<Wire> wire = std::exchange(kept, nullptr);
  if (!repeatable(request.method)) wire.reset();
  const bool may_repeat = wire && wire->used && !request.file;
  if (!wire) wire = new_wire();
  std::optional<HttpResponse> response;
  try {
    response = co_await once(wire, request, sink);
  } catch (const Error& error) {
    const bool again =
        may_repeat && !wire->answered && !wire->cancelled && error.kind() == ErrorKind::unreachable;
    if (!again) throw;
  }
  if (!response) {
    wire = new_wire();
    response = co_await once(wire, request, sink);
  }
  if (wire->stream.socket().is_open()) kept = wire;
  if (response->status >= 400 && request.errors_throw) throw_problem(*response);
  co_return std::move(*response);
}

HttpClient::HttpClient(asio::any_io_executor executor, std::string_view base_url, std::string token)
    : impl_(std::make_shared<Impl>()) {
  constexpr std::string_view scheme = "http://";
  if (!base_url.starts_with(scheme))
    throw Error(ErrorKind::bad_input,
                fmt::format("expected a URL as http://HOST:PORT, found \"{}\"", base_url));
  std::string_view rest = base_url.substr(scheme.size());
  while (rest.ends_with('/')) rest.remove_suffix(1);
  const std::size_t slash = rest.find('/');
  impl_->executor = std::move(executor);
  impl_->base_url = base_url;
  impl_->address = parse_address(rest.substr(0, slash), 80);
  impl_->prefix = slash == std::string_view::npos ? "" : std::string(rest.substr(slash));
  impl_->host_header = impl_->address.text();
  impl_->token = std::move(token);
}
HttpClient::~HttpClient() = default;
HttpClient::HttpClient(HttpClient&&) noexcept = default;

const std::string& HttpClient::base_url() const { return impl_->base_url; }

asio::awaitable<HttpResponse> HttpClient::send(HttpRequest request) {
  const auto impl = impl_;
  HttpResponse response = co_await impl->run(std::move(request), nullptr);
  co_return response;
}

asio::awaitable<HttpResponse> HttpClient::download(HttpRequest request, Sink sink) {
  const auto impl = impl_;
  HttpResponse response = co_await impl->run(std::move(request), &sink);
  co_return response;
}

asio::awaitable<void> HttpClient::events(std::string target, std::string last_event_id,
                                         Duration silence,
                                         std::function<bool(const ServerEvent&)> sink) {
  const auto impl = impl_;
  HttpRequest request;
  request.target = std::move(target);
  request.time = silence;
  request.headers.emplace_back("Accept", "text/event-stream");
  if (!last_event_id.empty()) request.headers.emplace_back("Last-Event-ID", last_event_id);
  const std::shared_ptr<Wire> wire = impl->new_wire();
  EventParser parser;
  bool done = false;
  const Sink take = [&](std::span<const std::byte> bytes) {
    std::string text(bytes.size(), '\0');
    std::copy(bytes.begin(), bytes.end(), std::as_writable_bytes(std::span(text)).begin());
    for (const ServerEvent& event : parser.feed(text))
      if (!done && !sink(event)) done = true;
    if (done) wire->cancelled = true;  // ends the reading; told apart from cancel() by `done`
  };
  try {
    const HttpResponse response = co_await impl->once(wire, request, &take);
    if (response.status >= 400) throw_problem(response);
  } catch (const Error&) {
    if (!done) throw;
  }
}

void HttpClient::cancel() {
  for (const std::weak_ptr<Wire>& weak : impl_->under_way)
    if (const std::shared_ptr<Wire> wire = weak.lock()) {
      wire->cancelled = true;
      wire->resolver.cancel();
      wire->stream.close();
    }
  impl_->kept.reset();
}

}  // namespace tessera::net
