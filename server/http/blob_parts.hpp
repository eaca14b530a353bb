#pragma once
#include <boost/asio/awaitable.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/thread_pool.hpp>
#include <cstdint>
#include <functional>
#include <optional>

#include "common/base/digest.hpp"
#include "server/coordinator/offload.hpp"
#include "server/http/routes.hpp"

/// What the handlers of blobs share.
namespace tessera::server {

/// Runs `work`, which may wait for a disk, on the pool for files.
template <class Result>
boost::asio::awaitable<Result> on_files(ApiContext& api, std::function<Result()> work) {
  const std::function<void(std::function<void()>)> post =
      [&pool = api.files](std::function<void()> job) { boost::asio::post(pool, std::move(job)); };
  co_return co_await offload<Result>(post, std::move(work));
}

struct BlobState {
  std::optional<std::uint64_t> size;  ///< nothing: not here, not whole
  std::uint64_t partial = 0;          ///< bytes kept of an upload that broke off
};

/// The digest that the path names. Throws Error{bad_input}.
Digest blob_digest(const Call& call);
boost::asio::awaitable<BlobState> blob_state(ApiContext& api, const Digest& digest);

}  // namespace tessera::server
