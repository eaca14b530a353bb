#pragma once
#include <boost/asio/awaitable.hpp>
#include <boost/asio/thread_pool.hpp>
#include <cstdint>
#include <functional>

#include "server/coordinator/films.hpp"

namespace tessera::server {

/// Takes the noise of a frame's film as it stands, on the pool, and tells it. Nothing is told of a
/// film that is forgotten meanwhile, or that cannot be read back, which fails its job by itself.
boost::asio::awaitable<void> look_at_noise(Films& films, boost::asio::thread_pool& pool, JobId job,
                                           std::int32_t frame, std::function<void(double)> tell);

}  // namespace tessera::server
