#include "worker/agent/fetch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "common/base/log.hpp"
#include "common/net/http_clients.hpp"

namespace tessera::agent {

namespace asio = boost::asio;

namespace {

constexpr std::size_t fetches_at_once = 4;

/// A blob that is lacking.
struct Lacking {
  Digest digest;
  std::uint64_t most = 0;  ///< bytes that it may have
};

/// Blobs on their way from the server into the cache, several at once. Runs on the calling thread.
class Download {
 public:
  Download(assets::BlobStore& cache, const FetchSettings& settings, std::vector<Lacking> list,
           std::function<void(std::uint64_t)> on_bytes)
      : cache_(cache),
        settings_(settings),
        list_(std::move(list)),
        on_bytes_(std::move(on_bytes)) {}

  void run(const std::string& url, const std::string& token, const std::stop_token& stop) {
    if (list_.empty()) return;
    asio::io_context io(1);
    net::HttpClients clients(io.get_executor(), url, token,
                             std::min(fetches_at_once, list_.size()));
    std::exception_ptr failure;
    clients.run([&](net::HttpClient& client) { return get_some(clients, client); },
                [&](std::exception_ptr error) { failure = std::move(error); });
    const std::stop_callback cancel(stop, [&] { asio::post(io, [&] { clients.cancel(); }); });
    io.run();
    if (failure) std::rethrow_exception(failure);
  }

 private:
  asio::awaitable<void> get_some(net::HttpClients& all, net::HttpClient& client) {
    while (next_ < list_.size() && !all.cancelled()) {
      const Lacking blob = list_[next_++];
      co_await get(all, client, blob);
    }
  }

  asio::awaitable<void> get(net::HttpClients& all, net::HttpClient& client, Lacking blob) {
    std::optional<assets::BlobStore::Writer> writer;  // holds what came, whatever breaks off
    Duration wait = settings_.first_wait;
    for (int attempt = 1;; ++attempt) {
      const std::uint64_t before = writer ? writer->size() : 0;
      const std::exception_ptr trouble = co_await get_once(client, blob, writer);
      if (!trouble) co_return;
      if (attempt >= settings_.tries || all.cancelled()) std::rethrow_exception(trouble);
      if (writer && writer->size() > before) {
        attempt = 0;
        wait = settings_.first_wait;
      }
      co_await all.pause(wait);
      wait *= 2;
    }
  }

  /// The blob, or what is lacking of it in `writer`. Gives what went wrong where another attempt
  /// may go better.
  asio::awaitable<std::exception_ptr> get_once(net::HttpClient& client, const Lacking& blob,
                                               std::optional<assets::BlobStore::Writer>& writer) {
    if (!writer) writer.emplace(cache_.writer(blob.digest));
    net::HttpRequest request;
    request.target = "/v1/blobs/" + blob.digest.hex();
    if (writer->size() > 0)
      request.headers.emplace_back("Range", fmt::format("bytes={}-", writer->size()));
    request.head = [&](const net::HttpResponse& response) {
      constexpr int whole = 200;
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
      const Error told(error.kind(),
                       fmt::format("cannot fetch blob {} from {}: {}", blob.digest.hex(),
                                   client.base_url(), error.what()));
      log::warn("{}", told.what());
      // Refused, or not there, or another size: another try would change nothing.
      if (error.kind() == ErrorKind::refused || error.kind() == ErrorKind::not_found ||
          error.kind() == ErrorKind::too_large)
        throw told;
      co_return std::make_exception_ptr(told);
    }
  }

  void finish(const Lacking& blob, std::optional<assets::BlobStore::Writer>& writer) {
    try {
      writer->commit();
    } catch (const Error&) {
      restart(blob, writer);
      throw;
    }
  }

  void restart(const Lacking& blob, std::optional<assets::BlobStore::Writer>& writer) {
    done_ -= writer->size();
    writer.reset();
    writer.emplace(cache_.writer(blob.digest));
  }

  assets::BlobStore& cache_;
  const FetchSettings& settings_;
  std::vector<Lacking> list_;
  std::function<void(std::uint64_t)> on_bytes_;
  std::size_t next_ = 0;
  std::uint64_t done_ = 0;
};

}  // namespace

bool Fetcher::here(const Digest& digest) {
  if (!cache_.has(digest)) return false;
  if (trusted_.contains(digest)) return true;
  if (!cache_.verify(digest)) {
    log::warn("blob {} in the cache is damaged; it is fetched again", digest.hex());
    return false;
  }
  trusted_.insert(digest);
  return true;
}

std::optional<FetchedBundle> Fetcher::fetch(const Digest& bundle, const std::string& blob_url,
                                            const std::string& token, const Fraction& progress,
                                            std::stop_token stop) {
  const auto get = [&](std::vector<Lacking> list,
                       const std::function<void(std::uint64_t)>& on_bytes) {
    Download download(cache_, settings_, list, on_bytes);
    download.run(blob_url, token, stop);
    for (const Lacking& blob : list) trusted_.insert(blob.digest);
  };
  FetchedBundle fetched;
  try {
    fetched.bundle_pin = cache_.pin({bundle});
    if (!here(bundle)) get({{bundle, assets::bundle_json_most}}, [](std::uint64_t) {});
    fetched.bundle = assets::bundle_from_json(cache_.read(bundle, assets::bundle_json_most),
                                              "bundle " + bundle.hex());
    // Pinned before it is looked which are here: none of them goes from now on.
    fetched.files_pin = cache_.pin(assets::digests_of(fetched.bundle));
    const double total =
        static_cast<double>(std::max<std::uint64_t>(assets::total_size(fetched.bundle), 1));
    std::uint64_t here_already = 0;
    const auto report = [&](std::uint64_t come) {
      progress(std::min(1.0, static_cast<double>(here_already + come) / total));
    };
    std::set<Digest> seen;
    std::vector<Lacking> lacking;
    for (const auto& [path, file] : fetched.bundle.files) {
      if (stop.stop_requested()) return std::nullopt;
      fetched.files[path] = cache_.path(file.digest);
      if (!seen.insert(file.digest).second) continue;
      if (!here(file.digest)) {
        lacking.push_back({file.digest, file.size});
        continue;
      }
      here_already += file.size;
      report(0);
    }
    get(std::move(lacking), report);
    for (const auto& [path, file] : fetched.bundle.files)
      if (cache_.size(file.digest) != file.size)
        throw Error(
            ErrorKind::bad_input,
            fmt::format("the bundle says that the file has {} bytes, its blob has another number",
                        file.size),
            {.file = path});
    progress(1);
  } catch (const Error&) {
    if (stop.stop_requested()) return std::nullopt;
    throw;
  }
  cache_.evict(settings_.cache_bytes);
  return fetched;
}

}  // namespace tessera::agent
