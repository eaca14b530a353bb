#pragma once
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/thread_pool.hpp>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/assets/blob_store.hpp"
#include "common/base/random.hpp"
#include "fake_coordinator.hpp"
#include "server/http/api.hpp"

/// An Api over a fake coordinator and a true blob store, asked without a socket.
namespace tessera::server {

/// A body that stands in memory, given in pieces.
class TextBody : public BodyReader {
 public:
  explicit TextBody(std::string text, std::size_t piece = 1 << 20)
      : text_(std::move(text)), piece_(piece) {}
  boost::asio::awaitable<std::size_t> read(std::span<std::byte> buffer) override {
    if (breaks_at && at_ >= *breaks_at)
      throw Error(ErrorKind::bad_input, "the request's body broke off");
    const std::size_t size = std::min({buffer.size(), piece_, text_.size() - at_});
    std::memcpy(buffer.data(), text_.data() + at_, size);
    at_ += size;
    co_return size;
  }
  [[nodiscard]] std::optional<std::uint64_t> length() const override { return text_.size(); }
  [[nodiscard]] std::size_t bytes_read() const { return at_; }
  std::optional<std::size_t> breaks_at;

 private:
  std::string text_;
  std::size_t piece_;
  std::size_t at_ = 0;
};

/// Runs the coroutine to its end and gives back what it does.
template <class Result>
Result finish(boost::asio::io_context& context, boost::asio::awaitable<Result> work) {
  std::optional<Result> result;
  std::exception_ptr error;
  boost::asio::co_spawn(context, std::move(work), [&](std::exception_ptr failure, Result value) {
    error = failure;
    result = std::move(value);
  });
  context.restart();
  const auto guard = boost::asio::make_work_guard(context);
  while (!result) context.run_one();
  if (error) std::rethrow_exception(error);
  return std::move(*result);
}

class ApiTest : public ::testing::Test {
 protected:
  ~ApiTest() override { std::filesystem::remove_all(folder); }

  HttpResponse ask(const std::string& method, const std::string& target,
                   const std::string& body = {}, const HttpFields& fields = {}) {
    TextBody reader(body);
    return ask_with(method, target, reader, fields);
  }
  HttpResponse ask_with(const std::string& method, const std::string& target, BodyReader& body,
                        const HttpFields& fields = {}) {
    HttpRequest request;
    request.method = method;
    request.target = target;
    request.fields = fields;
    if (!request.field("host")) request.fields.emplace_back("host", "127.0.0.1:8420");
    request.body = &body;
    return finish(context, api.handle(request));
  }
  static ApiSettings loopback() {
    ApiSettings settings;
    settings.access.port = 8420;
    return settings;
  }

  /// What a body says; files are read.
  static std::string text(const HttpResponse& response) {
    if (const auto* own = std::get_if<std::string>(&response.body)) return *own;
    if (const auto* fixed = std::get_if<std::string_view>(&response.body))
      return std::string(*fixed);
    if (const auto* bytes = std::get_if<SharedBytes>(&response.body))
      return {reinterpret_cast<const char*>((*bytes)->data()), (*bytes)->size()};
    if (const auto* slice = std::get_if<FileSlice>(&response.body)) {
      std::ifstream file(slice->file, std::ios::binary);
      file.seekg(static_cast<std::streamoff>(slice->offset));
      std::string out(slice->length, '\0');
      file.read(out.data(), static_cast<std::streamsize>(out.size()));
      return out.substr(0, static_cast<std::size_t>(file.gcount()));
    }
    return {};
  }
  static Json json(const HttpResponse& response) { return Json::parse(text(response)); }

  boost::asio::io_context context;
  boost::asio::thread_pool files{1};
  std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("tessera-http-" + random_hex(8));
  FakeCoordinator coordinator;
  assets::BlobStore blobs{folder, false};
  Api api{coordinator, blobs, files, loopback()};
};

}  // namespace tessera::server
