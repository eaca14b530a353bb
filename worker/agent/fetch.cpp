#include "worker/agent/fetch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <condition_variable>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "common/base/log.hpp"
#include "common/net/http_client.hpp"

namespace tessera::agent {

namespace asio = boost::asio;

/// Where blobs come from: a client that runs on the calling thread.
struct Fetcher::Source {
  Source(const std::string& url, const std::string& token, std::stop_token stopped)
      : stop(std::move(stopped)), client(io.get_executor(), url, token) {}

  asio::io_context io;
  std::stop_token stop;
  net::HttpClient client;

  net::HttpResponse get(const std::string& target,
                        const std::function<void(std::span<const std::byte>)>& sink) {
    net::HttpResponse response;
    std::exception_ptr failure;
    const std::stop_callback cancel(stop, [this] { asio::post(io, [this] { client.cancel(); }); });
    net::HttpRequest request;
    request.target = target;
    asio::co_spawn(io, client.download(std::move(request), sink),
                   [&](std::exception_ptr error, net::HttpResponse got) {
                     failure = error;
                     response = std::move(got);
                   });
    io.restart();
    io.run();
    if (failure) std::rethrow_exception(failure);
    return response;
  }
};

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

void Fetcher::get_once(Source& source, const Digest& digest, std::uint64_t most,
                       const std::function<void(std::uint64_t)>& on_bytes) {
  assets::BlobStore::Writer writer = cache_.writer(digest);
  source.get("/v1/blobs/" + digest.hex(), [&](std::span<const std::byte> bytes) {
    if (writer.size() + bytes.size() > most)
      throw Error(ErrorKind::too_large,
                  fmt::format("more than the {} bytes that were announced", most));
    writer.write(bytes);
    on_bytes(writer.size());
  });
  writer.commit();
  trusted_.insert(digest);
}

void Fetcher::get(Source& source, const Digest& digest, std::uint64_t most,
                  const std::function<void(std::uint64_t)>& on_bytes) {
  Duration wait = settings_.first_wait;
  for (int attempt = 1;; ++attempt) {
    try {
      return get_once(source, digest, most, on_bytes);
    } catch (const Error& error) {
      // Refused, or not there: another try would change nothing.
      const bool lasting = error.kind() == ErrorKind::refused ||
                           error.kind() == ErrorKind::not_found ||
                           error.kind() == ErrorKind::too_large;
      if (lasting || attempt >= settings_.tries || source.stop.stop_requested())
        throw Error(error.kind(), fmt::format("cannot fetch blob {} from {}: {}", digest.hex(),
                                              source.client.base_url(), error.what()));
      log::warn("fetching blob {}: {}; trying again", digest.hex(), error.what());
    }
    std::mutex mutex;
    std::unique_lock lock(mutex);
    std::condition_variable_any wake;
    wake.wait_for(lock, source.stop, wait, [] { return false; });
    wait *= 2;
  }
}

std::optional<FetchedBundle> Fetcher::fetch(const Digest& bundle, const std::string& blob_url,
                                            const std::string& token, const Fraction& progress,
                                            std::stop_token stop) {
  Source source(blob_url, token, stop);
  FetchedBundle fetched;
  try {
    fetched.bundle_pin = cache_.pin({bundle});
    if (!here(bundle)) get(source, bundle, assets::bundle_json_most, [](std::uint64_t) {});
    fetched.bundle = assets::bundle_from_json(cache_.read(bundle, assets::bundle_json_most),
                                              "bundle " + bundle.hex());
    // Pinned before it is looked which are here: none of them goes from now on.
    fetched.files_pin = cache_.pin(assets::digests_of(fetched.bundle));
    const double total =
        static_cast<double>(std::max<std::uint64_t>(assets::total_size(fetched.bundle), 1));
    std::set<Digest> done;
    std::uint64_t bytes_done = 0;
    for (const auto& [path, file] : fetched.bundle.files) {
      if (stop.stop_requested()) return std::nullopt;
      fetched.files[path] = cache_.path(file.digest);
      if (!done.insert(file.digest).second) continue;
      const auto report = [&](std::uint64_t bytes) {
        progress(std::min(1.0, static_cast<double>(bytes_done + bytes) / total));
      };
      if (!here(file.digest)) get(source, file.digest, file.size, report);
      if (cache_.size(file.digest) != file.size)
        throw Error(
            ErrorKind::bad_input,
            fmt::format("the bundle says that the file has {} bytes, its blob has another number",
                        file.size),
            {.file = path});
      bytes_done += file.size;
      report(0);
    }
  } catch (const Error&) {
    if (stop.stop_requested()) return std::nullopt;
    throw;
  }
  cache_.evict(settings_.cache_bytes);
  return fetched;
}

}  // namespace tessera::agent
