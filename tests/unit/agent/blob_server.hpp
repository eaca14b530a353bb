#pragma once
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>
#include <map>
#include <mutex>
#include <string>
#include <thread>

#include "common/assets/bundle.hpp"
#include "common/base/digest.hpp"

namespace tessera::agent {

/// Serves blobs at /v1/blobs/{sha256}, and what is left of them from a byte on, one connection at a
/// time, one request a connection.
class BlobServer {
 public:
  BlobServer() : thread_([this] { serve(); }) {}
  ~BlobServer() {
    stopping_ = true;
    boost::asio::io_context io;
    boost::system::error_code ignored;
    boost::asio::ip::tcp::socket(io).connect(acceptor_.local_endpoint(), ignored);
    thread_.join();
  }
  Digest add(const std::string& bytes) {
    const std::lock_guard lock(mutex_);
    const Digest digest = digest_of(bytes);
    blobs_[digest.hex()] = bytes;
    return digest;
  }
  /// What the digest is answered with from now on.
  void answer_with(const Digest& digest, const std::string& bytes) {
    const std::lock_guard lock(mutex_);
    blobs_[digest.hex()] = bytes;
  }
  std::string text_of(const Digest& digest) {
    const std::lock_guard lock(mutex_);
    return blobs_.at(digest.hex());
  }
  /// A scene of two files; gives the bundle's digest.
  Digest add_scene(const std::string& scene_text, const std::string& mesh) {
    assets::Bundle bundle;
    bundle.scene = "scene.json";
    bundle.files["scene.json"] = {.digest = add(scene_text), .size = scene_text.size()};
    bundle.files["meshes/a.obj"] = {.digest = add(mesh), .size = mesh.size()};
    return add(assets::canonical_json(bundle));
  }
  std::string url() {
    return "http://127.0.0.1:" + std::to_string(acceptor_.local_endpoint().port());
  }
  std::atomic<int> requests = 0;
  std::atomic<int> break_next = 0;  ///< so many requests are answered with nothing
  std::atomic<int> cut_next = 0;    ///< so many with half of what is left, and no more
  std::atomic<bool> knows_ranges = true;
  std::atomic<std::size_t> body_bytes = 0;  ///< sent in all

 private:
  void serve() {
    while (true) {
      auto socket = acceptor_.accept();
      if (stopping_) return;
      boost::system::error_code error;
      std::string request;
      boost::asio::read_until(socket, boost::asio::dynamic_buffer(request), "\r\n\r\n", error);
      if (error) continue;
      ++requests;
      if (break_next > 0) {
        --break_next;
        continue;
      }
      const std::lock_guard lock(mutex_);
      const bool admitted = request.find("Authorization: Bearer blobs\r\n") != std::string::npos;
      const auto found = blobs_.find(request.substr(std::string("GET /v1/blobs/").size(), 64));
      const bool there = found != blobs_.end();
      std::string body = admitted && there ? found->second : "";
      const std::size_t range = knows_ranges ? request.find("Range: bytes=") : std::string::npos;
      const bool part = there && range != std::string::npos;
      if (part) body = body.substr(std::stoul(request.substr(range + 13)));
      const std::string length = std::to_string(body.size());
      if (there && cut_next > 0 && --cut_next >= 0) body.resize(body.size() / 2);
      body_bytes += body.size();
      boost::asio::write(
          socket, boost::asio::buffer(head(admitted, there, part) + length + "\r\n\r\n" + body),
          error);
    }
  }
  static std::string head(bool admitted, bool there, bool part) {
    const std::string status = !admitted ? "401 No"
                               : !there  ? "404 No"
                               : part    ? "206 Part"
                                         : "200 OK";
    return "HTTP/1.1 " + status + "\r\nConnection: close\r\nContent-Length: ";
  }
  std::map<std::string, std::string> blobs_;
  std::mutex mutex_;
  boost::asio::io_context io_;
  boost::asio::ip::tcp::acceptor acceptor_{
      io_, boost::asio::ip::tcp::endpoint(boost::asio::ip::address_v4::loopback(), 0)};
  std::atomic<bool> stopping_ = false;
  std::thread thread_;
};

}  // namespace tessera::agent
