#include "tests/farm/scripted_worker.hpp"

#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

#include "common/wire/codec.hpp"

namespace tessera::farm_test {

using Clock = std::chrono::steady_clock;

Line::Line(const std::string& address) {
  const std::size_t colon = address.rfind(':');
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<std::uint16_t>(std::stoi(address.substr(colon + 1))));
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socket_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0)
    throw std::runtime_error("cannot connect to " + address);
  const int on = 1;
  setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
}

Line::~Line() {
  if (socket_ >= 0) close(socket_);
}

Line::Line(Line&& other) noexcept : socket_(std::exchange(other.socket_, -1)) {}

bool Line::send(std::span<const std::byte> bytes) const {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(sent));
  }
  return true;
}

bool Line::send(std::string_view text) const { return send(std::as_bytes(std::span(text))); }

bool Line::send(const wire::OutFrame& frame) const {
  const auto piece = [](std::span<const std::byte> bytes) {
    return iovec{const_cast<std::byte*>(bytes.data()), bytes.size()};
  };
  std::array<iovec, 3> pieces{piece(std::as_bytes(std::span(frame.head))), piece(frame.body),
                              piece(frame.crc)};
  msghdr message{};
  message.msg_iov = pieces.data();
  message.msg_iovlen = pieces.size();
  const ssize_t sent = ::sendmsg(socket_, &message, MSG_NOSIGNAL);
  if (sent < 0) return false;
  auto done = static_cast<std::size_t>(sent);
  for (const iovec& one : pieces) {
    const std::size_t here = std::min(done, one.iov_len);
    done -= here;
    const std::span<const std::byte> rest(static_cast<const std::byte*>(one.iov_base), one.iov_len);
    if (here < rest.size() && !send(rest.subspan(here))) return false;
  }
  return true;
}

std::size_t Line::receive(std::span<std::byte> room, Seconds most) const {
  pollfd waiting{socket_, POLLIN, 0};
  if (poll(&waiting, 1, static_cast<int>(most.count() * 1000)) <= 0) return 0;
  const ssize_t got = recv(socket_, room.data(), room.size(), 0);
  return got > 0 ? static_cast<std::size_t>(got) : 0;
}

std::vector<std::byte> Line::receive(Seconds most) const {
  std::vector<std::byte> piece(limits::wire_chunk);
  piece.resize(receive(piece, most));
  return piece;
}

std::string Line::receive_all(Seconds most) const {
  std::string all;
  const auto end = Clock::now() + most;
  while (Clock::now() < end) {
    const auto piece = receive(end - Clock::now());
    if (piece.empty()) break;
    all.append(reinterpret_cast<const char*>(piece.data()), piece.size());
  }
  return all;
}

bool Line::closed_within(Seconds most) const {
  const auto end = Clock::now() + most;
  while (Clock::now() < end) {
    pollfd waiting{socket_, POLLIN, 0};
    if (poll(&waiting, 1, 50) <= 0) continue;
    std::byte piece[4096];
    if (recv(socket_, piece, sizeof piece, 0) <= 0) return true;
  }
  return false;
}

ScriptedWorker::ScriptedWorker(const std::string& address, const ScriptedHello& hello)
    : line_(address) {
  wire::Hello first;
  first.token = hello.token;
  first.name = hello.name;
  first.identity = hello.identity;
  first.threads = hello.threads;
  first.build_id = hello.build_id;
  first.version = "test";
  say(first);
  reader_.welcomed();
  auto heard = hear();
  if (!heard) throw std::runtime_error("no answer to hello");
  answer_ = std::move(*heard);
}

bool ScriptedWorker::say(const wire::Message& message, std::span<const std::byte> body) const {
  const wire::EncodedMessage encoded = wire::encode(message);
  const wire::OutFrame first = wire::first_frame(encoded.type, encoded.header, body);
  if (!line_.send(first)) return false;
  for (auto rest = body.subspan(first.body.size()); !rest.empty();) {
    const wire::OutFrame chunk = wire::chunk_frame(rest);
    if (!line_.send(chunk)) return false;
    rest = rest.subspan(chunk.body.size());
  }
  return true;
}

std::optional<wire::Message> ScriptedWorker::hear(Seconds most) {
  const auto end = Clock::now() + most;
  for (;;) {
    const auto frame = reader_.read(unread_);
    if (frame) return wire::decode(frame->type, frame->header);
    const Seconds left = end - Clock::now();
    if (left.count() <= 0) return std::nullopt;
    unread_ = std::span<const std::byte>(room_).first(line_.receive(room_, left));
    if (unread_.empty()) return std::nullopt;
  }
}

std::optional<AssignedTask> ScriptedWorker::next_task(Seconds most) {
  const auto end = Clock::now() + most;
  for (Seconds left = most; left.count() > 0; left = end - Clock::now()) {
    std::optional<wire::Message> message;
    if (!heard_.empty()) {
      message = std::move(heard_.front());
      heard_.pop_front();
    } else {
      message = hear(left);
    }
    if (!message) return std::nullopt;
    auto* assign = std::get_if<wire::Assign>(&*message);
    if (assign == nullptr) continue;
    if (assign->spec) {
      plans_.try_emplace(assign->job, *assign->spec);
      say(wire::Preparing{assign->job, 0.5});
      say(wire::Ready{assign->job});
    }
    const auto known = plans_.find(assign->job);
    if (known != plans_.end()) return AssignedTask{std::move(*assign), known->second};
  }
  return std::nullopt;
}

image::TileImage ScriptedWorker::good_image(const AssignedTask& task) {
  const TaskId& id = task.assign.task;
  image::TileImage tile;
  tile.window = task.plan.grid.tile(id.tile);
  tile.film_width = task.plan.grid.film_width();
  tile.film_height = task.plan.grid.film_height();
  const auto samples = static_cast<std::uint32_t>(task.plan.passes.pass(id.pass).count);
  tile.samples[0] = samples;
  tile.samples[1] = task.plan.passes.has_aovs(id.pass, task.plan.spec.aov_samples) ? samples : 0;
  tile.values.resize(tile.channels() * tile.pixels());
  for (std::size_t i = 0; i < tile.values.size(); ++i)
    tile.values[i] = static_cast<float>((i * 2654435761U + id.pass * 40503U) % 1024) / 1024.0F;
  return tile;
}

std::vector<std::byte> ScriptedWorker::good_tile(const AssignedTask& task) {
  return image::encode_tile(good_image(task));
}

wire::Result ScriptedWorker::result_of(const AssignedTask& task) {
  wire::Result result;
  result.lease = task.assign.lease;
  result.job = task.assign.job;
  result.plan = task.assign.plan;
  result.task = task.assign.task;
  result.samples = task.plan.grid.tile(result.task.tile).pixels() *
                   task.plan.passes.pass(result.task.pass).count;
  result.rays = result.samples;
  result.seconds = 0.001;
  result.cpu_seconds = 0.001;
  return result;
}

namespace {
bool answers(const wire::Message& message, const LeaseId& lease) {
  if (const auto* accepted = std::get_if<wire::Accepted>(&message)) return accepted->lease == lease;
  if (const auto* stale = std::get_if<wire::Stale>(&message)) return stale->lease == lease;
  if (const auto* rejected = std::get_if<wire::Rejected>(&message)) return rejected->lease == lease;
  return false;
}
}  // namespace

std::optional<wire::Message> ScriptedWorker::deliver(const wire::Result& result,
                                                     std::span<const std::byte> body) {
  if (!say(result, body)) return std::nullopt;
  const auto end = Clock::now() + Seconds(10);
  while (Clock::now() < end) {
    auto message = hear(end - Clock::now());
    if (!message) return std::nullopt;
    if (answers(*message, result.lease)) return message;
    heard_.push_back(std::move(*message));
  }
  return std::nullopt;
}

}  // namespace tessera::farm_test
