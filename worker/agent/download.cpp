#include "worker/agent/download.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/log.hpp"

namespace tessera::agent {

namespace asio = boost::asio;

namespace {
constexpr std::size_t fetches_at_once = 4;
constexpr int whole = 200;  // the status of an answer that is not a part
}  // namespace

void Download::run(const std::string& url, const std::string& token, const std::stop_token& stop) {
  if (blobs_.empty()) return;
  asio::io_context io(1);
  net::HttpClients clients(io.get_executor(), url, token, std::min(fetches_at_once, blobs_.size()));
  std::exception_ptr failure;
  clients.run([&](net::HttpClient& client) { return get_some(clients, client); },
              [&](std::exception_ptr error) { failure = std::move(error); });
  const std::stop_callback cancel(stop, [&] { asio::post(io, [&] { clients.cancel(); }); });
  io.run();
  if (failure) std::rethrow_exception(failure);
}

asio::awaitable<void> Download::get_some(net::HttpClients& all, net::HttpClient& client) {
  while (next_ < blobs_.size() && !all.cancelled()) {
    const Lacking blob = blobs_[next_++];
    co_await get(all, client, blob);
  }
}

asio::awaitable<void> Download::get(net::HttpClients& all, net::HttpClient& client, Lacking blob) {
  Writer writer;  // keeps what came, whatever breaks off
  Duration wait = patience_.first_wait;
  for (int attempt = 1;; ++attempt) {
    const std::uint64_t before = writer ? writer->size() : 0;
    const std::exception_ptr trouble = co_await get_once(client, blob, writer);
    if (!trouble) co_return;
    if (attempt >= patience_.tries || all.cancelled()) std::rethrow_exception(trouble);
    if (writer && writer->size() > before) {
      attempt = 0;
      wait = patience_.first_wait;
    }
    co_await all.pause(wait);
    wait *= 2;
  }
}

asio::awaitable<std::exception_ptr> Download::get_once(net::HttpClient& client, const Lacking& blob,
                                                       Writer& writer) {
  if (!writer) writer.emplace(cache_.writer(blob.digest));
  net::HttpRequest request;
  request.target = "/v1/blobs/" + blob.digest.hex();
  if (writer->size() > 0)
    request.headers.emplace_back("Range", fmt::format("bytes={}-", writer->size()));
  request.head = [&](const net::HttpResponse& response) {
    if (response.status == whole && writer->size() > 0) restart(blob, writer);
  };
  std::function<void(std::span<const std::byte>)> sink = [&](std::span<const std::byte> bytes) {
    if (writer->size() + bytes.size() > blob.most)
      throw Error(ErrorKind::too_large,
                  fmt::format("more than the {} bytes that were announced", blob.most));
    writer->write(bytes);
    on_bytes_(done_ += bytes.size());
  };
  try {
    co_await client.download(std::move(request), std::move(sink));
    finish(blob, writer);
    co_return nullptr;
  } catch (const Error& error) {
    const Error told(error.kind(), fmt::format("cannot fetch blob {} from {}: {}",
                                               blob.digest.hex(), client.base_url(), error.what()));
    log::warn("{}", told.what());
    // Refused, or not there, or another size: another try would change nothing.
    if (error.kind() == ErrorKind::refused || error.kind() == ErrorKind::not_found ||
        error.kind() == ErrorKind::too_large)
      throw told;
    co_return std::make_exception_ptr(told);
  }
}

void Download::finish(const Lacking& blob, Writer& writer) {
  try {
    writer->commit();
  } catch (const Error&) {
    restart(blob, writer);
    throw;
  }
}

void Download::restart(const Lacking& blob, Writer& writer) {
  done_ -= writer->size();
  writer.reset();
  writer.emplace(cache_.writer(blob.digest));
}

}  // namespace tessera::agent
