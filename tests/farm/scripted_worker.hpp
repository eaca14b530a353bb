#pragma once
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/limits.hpp"
#include "common/image/tile.hpp"
#include "common/job/job_spec.hpp"
#include "common/wire/framing.hpp"
#include "common/wire/messages.hpp"
#include "tests/farm/process.hpp"

/// Peers that say just what a test wants: a plain blocking socket, and a worker without a renderer
/// on top of it.
namespace tessera::farm_test {

/// A blocking TCP connection to a loopback port.
class Line {
 public:
  /// "127.0.0.1:PORT".
  explicit Line(const std::string& address);
  ~Line();
  Line(Line&& other) noexcept;
  Line(const Line&) = delete;
  Line& operator=(const Line&) = delete;

  /// False if the other side has closed.
  bool send(std::span<const std::byte> bytes) const;
  bool send(std::string_view text) const;
  /// One frame, its body straight from where it is.
  bool send(const wire::OutFrame& frame) const;
  /// Whatever comes within `most`; empty at the end of the connection or of the time.
  [[nodiscard]] std::vector<std::byte> receive(Seconds most) const;
  /// The same, into `room`: how many bytes came.
  [[nodiscard]] std::size_t receive(std::span<std::byte> room, Seconds most) const;
  /// All until the other side closes or `most` is over.
  [[nodiscard]] std::string receive_all(Seconds most) const;
  /// True if the other side closes within `most`; what it says before is dropped.
  [[nodiscard]] bool closed_within(Seconds most) const;

 private:
  int socket_ = -1;
};

struct ScriptedHello {
  std::string token;
  std::string identity = "00112233445566778899aabbccddeeff";
  std::string name = "scripted";
  int threads = 1;
  Digest build_id{};
};

/// A task as it was assigned, with the plan of its job, which lives as long as the worker.
struct AssignedTask {
  wire::Assign assign;
  const JobPlan& plan;
};

class ScriptedWorker {
 public:
  explicit ScriptedWorker(const std::string& address, const ScriptedHello& hello = {});

  /// The coordinator's answer to the hello.
  [[nodiscard]] const wire::Message& answer() const { return answer_; }
  [[nodiscard]] bool welcomed() const { return std::holds_alternative<wire::Welcome>(answer_); }

  bool say(const wire::Message& message, std::span<const std::byte> body = {}) const;
  /// The next message, or nullopt after `most` or at the end.
  std::optional<wire::Message> hear(Seconds most = Seconds(10));
  /// Hears until a lease comes; says preparing and ready for a job it did not know.
  std::optional<AssignedTask> next_task(Seconds most = Seconds(10));
  /// A result that the coordinator should take: a tile whose values depend on task and pixel alone,
  /// as EXR.
  static std::vector<std::byte> good_tile(const AssignedTask& task);
  /// The tile of good_tile() before it is EXR.
  static image::TileImage good_image(const AssignedTask& task);
  static wire::Result result_of(const AssignedTask& task);
  /// Says the result and hears until the coordinator answers for its lease.
  std::optional<wire::Message> deliver(const wire::Result& result, std::span<const std::byte> body);
  [[nodiscard]] const Line& line() const { return line_; }

 private:
  Line line_;
  wire::FrameReader reader_;
  std::vector<std::byte> room_ = std::vector<std::byte>(limits::wire_chunk);
  std::span<const std::byte> unread_;  ///< within `room_`
  std::deque<wire::Message> heard_;
  wire::Message answer_;
  std::map<JobId, JobPlan> plans_;
};

}  // namespace tessera::farm_test
