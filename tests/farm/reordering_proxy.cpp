#include "tests/farm/reordering_proxy.hpp"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <span>
#include <stdexcept>
#include <vector>

#include "common/wire/codec.hpp"
#include "common/wire/framing.hpp"

namespace tessera::farm_test {

namespace {

constexpr int patience_ms = 150;

sockaddr_in loopback(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

bool send_all(int socket, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(sent));
  }
  return true;
}

struct Held {
  std::uint32_t pass;
  std::vector<std::byte> bytes;
};

/// Sends what is held, the highest pass first; says how many overtook one that came before them, or
/// −1 if the line is dead.
int release(std::vector<Held>& held, int coordinator) {
  std::vector<std::size_t> order(held.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return held[a].pass > held[b].pass; });
  int overtook = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (std::any_of(order.begin() + static_cast<std::ptrdiff_t>(i), order.end(),
                    [&](std::size_t later) { return later < order[i]; }))
      ++overtook;
    if (!send_all(coordinator, held[order[i]].bytes)) return -1;
  }
  held.clear();
  return overtook;
}

}  // namespace

ReorderingProxy::ReorderingProxy(const std::string& coordinator, std::size_t held_most)
    : coordinator_(coordinator), held_most_(held_most) {
  listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address = loopback(0);
  socklen_t size = sizeof address;
  if (bind(listener_, reinterpret_cast<sockaddr*>(&address), size) != 0 ||
      ::listen(listener_, 4) != 0 ||
      getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0)
    throw std::runtime_error("the proxy cannot listen");
  address_ = "127.0.0.1:" + std::to_string(ntohs(address.sin_port));
  thread_ = std::thread([this] { serve(); });
}

ReorderingProxy::~ReorderingProxy() {
  stop_ = true;
  thread_.join();
  close(listener_);
}

std::vector<ReorderingProxy::Seen> ReorderingProxy::seen() const {
  const std::scoped_lock lock(mutex_);
  return seen_;
}

void ReorderingProxy::serve() {
  while (!stop_) {
    pollfd waiting{listener_, POLLIN, 0};
    if (poll(&waiting, 1, 50) <= 0) continue;
    const int worker = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    const int coordinator = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const sockaddr_in address =
        loopback(std::stoi(coordinator_.substr(coordinator_.rfind(':') + 1)));
    if (connect(coordinator, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0)
      relay(worker, coordinator);
    close(worker);
    close(coordinator);
  }
}

void ReorderingProxy::relay(int worker, int coordinator) {
  wire::FrameReader reader;
  reader.welcomed();
  std::vector<Held> held;
  std::array<std::byte, 65536> piece{};
  while (!stop_) {
    std::array<pollfd, 2> sides{pollfd{worker, POLLIN, 0}, pollfd{coordinator, POLLIN, 0}};
    const int ready = poll(sides.data(), sides.size(), patience_ms);
    if (ready == 0) {
      const int overtook = release(held, coordinator);
      if (overtook < 0) return;
      swapped_ += overtook;
    }
    if (sides[1].revents != 0) {
      const ssize_t got = recv(coordinator, piece.data(), piece.size(), 0);
      if (got <= 0 || !send_all(worker, std::span(piece).first(static_cast<std::size_t>(got))))
        return;
    }
    if (sides[0].revents == 0) continue;
    const ssize_t got = recv(worker, piece.data(), piece.size(), 0);
    if (got <= 0) return;
    std::span<const std::byte> bytes = std::span(piece).first(static_cast<std::size_t>(got));
    while (auto frame = reader.read(bytes)) {
      auto whole = wire::frame_bytes(frame->type, frame->header, frame->body);
      const wire::Message message = wire::decode(frame->type, frame->header);
      if (const auto* result = std::get_if<wire::Result>(&message)) {
        {
          const std::scoped_lock lock(mutex_);
          seen_.push_back({std::chrono::steady_clock::now(), result->seconds});
        }
        held.push_back({result->task.pass, std::move(whole)});
        if (held.size() >= held_most_) {
          const int overtook = release(held, coordinator);
          if (overtook < 0) return;
          swapped_ += overtook;
        }
      } else if (!send_all(coordinator, whole)) {
        return;
      }
    }
  }
}

}  // namespace tessera::farm_test
