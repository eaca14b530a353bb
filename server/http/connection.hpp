#pragma once
#include <boost/asio/awaitable.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/thread_pool.hpp>

#include "server/http/api.hpp"
#include "server/http/listener.hpp"

namespace tessera::server {

/// Answers requests on one connection until either side ends it, in order, HTTP/1.1 with
/// keep-alive. What is no HTTP gets 400 and the end; a peer that is silent, or does not read, is
/// cut off. Ends early when it is cancelled.
boost::asio::awaitable<void> serve_connection(boost::asio::ip::tcp::socket socket, Api& api,
                                              boost::asio::thread_pool& files,
                                              const HttpSettings& settings);

}  // namespace tessera::server
