#include "server/http/response_writer.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <ctime>
#include <fstream>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "common/base/log.hpp"
#include "server/coordinator/offload.hpp"

namespace tessera::server {

namespace asio = boost::asio;

namespace {

constexpr std::size_t file_piece = 256 * limits::KiB;

bool has_body(const HttpResponse& response) {
  return response.status != 304 && response.status != 204;
}

void add_field(std::string& head, std::string_view name, std::string_view value) {
  head += name;
  head += ": ";
  for (const char c : value)
    if (static_cast<unsigned char>(c) >= 0x20 && c != 0x7f) head += c;
  head += "\r\n";
}

/// The next bytes of an open file; empty if it is shorter than it was said to be.
std::vector<char> next_piece(std::ifstream& file, std::uint64_t left) {
  std::vector<char> piece(static_cast<std::size_t>(std::min<std::uint64_t>(left, file_piece)));
  file.read(piece.data(), static_cast<std::streamsize>(piece.size()));
  piece.resize(static_cast<std::size_t>(file.gcount()));
  return piece;
}

}  // namespace

asio::awaitable<bool> write_all(boost::beast::tcp_stream& stream, asio::const_buffer bytes,
                                Duration time) {
  while (bytes.size() > 0) {
    const asio::const_buffer piece = asio::buffer(bytes, limits::wire_chunk);
    stream.expires_after(time);
    boost::system::error_code error;
    co_await asio::async_write(stream, piece, asio::redirect_error(asio::use_awaitable, error));
    if (error) co_return false;
    bytes += piece.size();
  }
  co_return true;
}

std::string response_head(const HttpResponse& response, bool keep_alive) {
  std::string head =
      fmt::format("HTTP/1.1 {} {}\r\n", response.status, reason_phrase(response.status));
  add_field(head, "Date",
            fmt::format("{:%a, %d %b %Y %H:%M:%S} GMT", fmt::gmtime(std::time(nullptr))));
  for (const auto& [name, value] : response.fields) add_field(head, name, value);
  const auto length = response.length();
  if (length && has_body(response)) add_field(head, "Content-Length", std::to_string(*length));
  add_field(head, "Connection", keep_alive && length ? "keep-alive" : "close");
  return head + "\r\n";
}

asio::awaitable<bool> ResponseWriter::write(const HttpResponse& response, bool head_only,
                                            bool keep_alive) {
  std::string start = response_head(response, keep_alive);
  const bool body = !head_only && has_body(response);
  std::string_view text;
  if (const auto* own = std::get_if<std::string>(&response.body)) text = *own;
  if (const auto* fixed = std::get_if<std::string_view>(&response.body)) text = *fixed;
  if (body) start += text;
  if (!co_await write_all(stream_, asio::buffer(start), write_time_)) co_return false;
  if (!body) co_return true;
  if (const auto* bytes = std::get_if<SharedBytes>(&response.body))
    co_return *bytes == nullptr || co_await write_all(stream_, asio::buffer(**bytes), write_time_);
  if (const auto* slice = std::get_if<FileSlice>(&response.body))
    co_return co_await write_file(*slice);
  if (const auto* stream = std::get_if<std::shared_ptr<TextStream>>(&response.body))
    co_return co_await write_stream(**stream);
  co_return true;
}

asio::awaitable<bool> ResponseWriter::write_file(const FileSlice& slice) {
  const std::function<void(std::function<void()>)> post =
      [&pool = files_](std::function<void()> job) { asio::post(pool, std::move(job)); };
  const auto file = std::make_shared<std::ifstream>();
  const std::function<bool()> open = [file, slice] {
    file->open(slice.file, std::ios::binary);
    file->seekg(static_cast<std::streamoff>(slice.offset));
    return file->good();
  };
  bool good = co_await offload<bool>(post, open);
  std::uint64_t left = slice.length;
  while (good && left > 0) {
    const std::function<std::vector<char>()> read = [file, left] {
      return next_piece(*file, left);
    };
    const std::vector<char> piece = co_await offload<std::vector<char>>(post, read);
    good = !piece.empty();
    left -= piece.size();
    if (good && !co_await write_all(stream_, asio::buffer(piece), write_time_)) co_return false;
  }
  if (!good) log::error("{} could not be read to its end", slice.file.string());
  co_return good;
}

asio::awaitable<bool> ResponseWriter::write_stream(TextStream& text) {
  for (;;) {
    stream_.expires_never();
    const auto piece = co_await text.next();
    if (!piece) co_return true;
    if (!co_await write_all(stream_, asio::buffer(*piece), write_time_)) co_return false;
  }
}

}  // namespace tessera::server
