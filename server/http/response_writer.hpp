#pragma once
#include <boost/asio/awaitable.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <string>

#include "common/base/clock.hpp"
#include "server/http/message.hpp"

/// Sends answers. Included by the two files that know Beast alone.
namespace tessera::server {

/// Sends all bytes, 64 KiB at a time, each piece within `time`. False if the peer is gone or does
/// not read.
boost::asio::awaitable<bool> write_all(boost::beast::tcp_stream& stream,
                                       boost::asio::const_buffer bytes, Duration time);

/// The status line and fields, those about the connection and the length among them. Line breaks
/// cannot get into a field.
std::string response_head(const HttpResponse& response, bool keep_alive);

class ResponseWriter {
 public:
  ResponseWriter(boost::beast::tcp_stream& stream, boost::asio::thread_pool& files,
                 Duration write_time)
      : stream_(stream), files_(files), write_time_(write_time) {}

  /// `head_only`: without the body. False if the peer is gone or does not read: the connection is
  /// of no use then.
  boost::asio::awaitable<bool> write(const HttpResponse& response, bool head_only, bool keep_alive);

 private:
  boost::asio::awaitable<bool> write_file(const FileSlice& slice);
  boost::asio::awaitable<bool> write_stream(TextStream& text);

  boost::beast::tcp_stream& stream_;
  boost::asio::thread_pool& files_;
  Duration write_time_;
};

}  // namespace tessera::server
