#pragma once
#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/clock.hpp"
#include "common/base/limits.hpp"

namespace tessera::net {

/// Bytes [offset, offset + size) of a file, sent as they are read.
struct FileRange {
  std::filesystem::path file;
  std::uint64_t offset = 0;
  std::uint64_t size = 0;
  /// Told, if given, how many of the bytes have gone out, after each piece.
  std::function<void(std::uint64_t)> sent;
};

struct HttpResponse {
  int status = 0;
  std::vector<std::pair<std::string, std::string>> headers;
  std::string body;
  /// The first header of this name, in any case; empty if there is none.
  [[nodiscard]] std::string header(std::string_view name) const;
};

struct HttpRequest {
  std::string method = "GET";  ///< GET, HEAD, POST, PUT, PATCH or DELETE
  std::string target = "/";    ///< path and query, already encoded
  std::vector<std::pair<std::string, std::string>> headers;
  std::string body;  ///< or:
  std::optional<FileRange> file;
  std::size_t response_most =
      64 * limits::MiB;  ///< a longer body kept in memory is Error{too_large}
  Duration time =
      std::chrono::seconds(30);  ///< for each step: connect, one piece sent, one piece received
  bool errors_throw = true;      ///< false: a status of 400 and above is given back like any other
  /// Told, if given, the answer's status and headers before its body comes.
  std::function<void(const HttpResponse&)> head;
};

/// One server-sent event.
struct ServerEvent {
  std::string id;
  std::string type = "message";
  std::string data;
};

/// HTTP/1.1 to one server, over one connection that is kept. One request at a time; all calls on
/// the executor. Errors: Error{unreachable} where the server does not answer; for a status of 400
/// and above Error with the problem's detail (RFC 9457) and the kind that fits: 401, 403 refused;
/// 404 not_found; 409, 412 conflict; 413 too_large; 400, 422 bad_input; else failed.
class HttpClient {
 public:
  /// `base_url` is "http://host:port", perhaps with a path in front of all targets. `token` may be
  /// empty. Throws Error{bad_input} if it is no such URL.
  HttpClient(boost::asio::any_io_executor executor, std::string_view base_url, std::string token);
  ~HttpClient();
  HttpClient(HttpClient&&) noexcept;
  HttpClient& operator=(HttpClient&&) = delete;

  boost::asio::awaitable<HttpResponse> send(HttpRequest request);
  /// As send, but the body of a response below 400 goes to `sink` piece by piece, and response_most
  /// does not bound it. What the sink throws ends the request. Repeating a request after part of
  /// its body came is the caller's decision.
  boost::asio::awaitable<HttpResponse> download(
      HttpRequest request, std::function<void(std::span<const std::byte>)> sink);
  /// Server-sent events, until `sink` returns false, the server ends the stream, or cancel().
  /// `silence`: nothing for so long (comments count as something) is Error{unreachable}. It has a
  /// connection of its own for as long as it runs.
  boost::asio::awaitable<void> events(std::string target, std::string last_event_id,
                                      Duration silence,
                                      std::function<bool(const ServerEvent&)> sink);
  /// What is under way ends with Error{failed}, "cancelled"; later requests work.
  void cancel();

  [[nodiscard]] const std::string& base_url() const;

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

/// Percent-encodes all but letters, digits and "-._~" (RFC 3986): for one part of a path or query.
std::string url_encoded(std::string_view text);

/// Splits a stream of server-sent events (the HTML standard, 9.2) however its bytes are cut. Pure.
class EventParser {
 public:
  /// Throws Error{too_large} when a line or an event is longer than limits::http_json_body.
  std::vector<ServerEvent> feed(std::string_view bytes);

 private:
  void line(std::string_view text, std::vector<ServerEvent>& events);
  std::string rest_;
  bool skip_newline_ = false;
  bool first_ = true;
  bool has_data_ = false;
  std::string last_id_;
  ServerEvent event_;
};

}  // namespace tessera::net
