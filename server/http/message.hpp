#pragma once
#include <boost/asio/awaitable.hpp>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "common/base/json.hpp"

/// A request and a response as plain values: what handlers see, and what tests make by hand.
namespace tessera::server {

using HttpFields = std::vector<std::pair<std::string, std::string>>;

/// The body of a request, read as it arrives.
class BodyReader {
 public:
  virtual ~BodyReader() = default;
  /// The next bytes, as many as fit into `buffer` unless the body ends before; 0 at its end. Throws
  /// Error{bad_input} if the peer breaks off or is too slow.
  virtual boost::asio::awaitable<std::size_t> read(std::span<std::byte> buffer) = 0;
  /// What Content-Length says; nothing for a body in chunks.
  [[nodiscard]] virtual std::optional<std::uint64_t> length() const = 0;
};

struct HttpRequest {
  std::string method;          ///< as sent: "GET"
  std::string target = "/";    ///< as sent: path and query
  HttpFields fields;           ///< names in lower case
  BodyReader* body = nullptr;  ///< lives as long as the request

  /// The first field of this name (in lower case), or nothing.
  [[nodiscard]] std::optional<std::string_view> field(std::string_view name) const;
};

/// Text that is made while it is sent; the response has no length, and the connection ends with it.
class TextStream {
 public:
  virtual ~TextStream() = default;
  /// The next piece, or nothing at the end.
  virtual boost::asio::awaitable<std::optional<std::string>> next() = 0;
};

/// Bytes of a file, read by the pool in pieces while they are sent.
struct FileSlice {
  std::filesystem::path file;
  std::uint64_t offset = 0;
  std::uint64_t length = 0;
};

using SharedBytes = std::shared_ptr<const std::vector<std::byte>>;

struct HttpResponse {
  unsigned status = 200;
  HttpFields fields;  ///< Content-Length, Connection and Date are added when it is sent
  /// For 304, 204 and HEAD only its length counts.
  std::variant<std::string, std::string_view, SharedBytes, FileSlice, std::shared_ptr<TextStream>>
      body;

  [[nodiscard]] std::optional<std::string_view> field(std::string_view name) const;  ///< exact name
  /// Bytes in the body; nothing for a stream.
  [[nodiscard]] std::optional<std::uint64_t> length() const;
};

HttpResponse json_response(const Json& json, unsigned status = 200);
/// RFC 9457 problem details.
HttpResponse problem(unsigned status, std::string_view detail);
/// "OK", "Not Found", …
std::string_view reason_phrase(unsigned status);

}  // namespace tessera::server
