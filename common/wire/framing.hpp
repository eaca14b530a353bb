#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.hpp"

/// Frames: bytes to messages' headers and bodies, and back. Sans-IO; README.md has the layout.
namespace tessera::wire {

/// Type of the frames that bring the rest of a body that is longer than one frame carries.
constexpr std::uint16_t chunk_type = 256;
constexpr std::size_t prefix_bytes = 16;
constexpr std::size_t crc_bytes = 4;

enum class FrameProblem {
  http,       ///< the peer speaks HTTP
  tls,        ///< the peer begins a TLS handshake
  magic,      ///< neither: not this protocol
  version,    ///< another version of this protocol
  type,       ///< an unknown message type, or a body where there may be none
  too_large,  ///< a length beyond the limit
  crc,        ///< bytes changed on their way
  order,      ///< a chunk that belongs to no body, or does not go on where the last one ended
};

/// What the peer sent is no frame; the connection cannot be used any more. Of kind bad_input.
class FrameError : public Error {
 public:
  FrameError(FrameProblem problem, const std::string& message);
  [[nodiscard]] FrameProblem problem() const { return problem_; }

 private:
  FrameProblem problem_;
};

/// One whole message: its header and, where it has one, its whole body.
struct Frame {
  std::uint16_t type = 0;
  std::string header;
  std::vector<std::byte> body;
};

/// Bytes in, frames out, however the bytes are cut. It starts with the limits for strangers: 4 KiB
/// of header, no body.
class FrameReader {
 public:
  FrameReader();
  /// From the next frame on, the full limits hold: the peer has been welcomed.
  void welcomed() { welcomed_ = true; }
  /// Takes bytes from the front of `bytes`, which is moved on, up to the end of the first whole
  /// message, and gives that; nullopt when all bytes are taken and none is whole. Throws
  /// FrameError, also each time after the first.
  std::optional<Frame> read(std::span<const std::byte>& bytes);
  /// Frames that have come whole so far, chunks among them: as long as it grows, the peer is not
  /// stuck.
  [[nodiscard]] std::uint64_t frames() const { return frames_; }
  /// True if part of a message is here, and the rest is still to come.
  [[nodiscard]] bool in_message() const { return filled_ != 0 || body_left_ != 0; }

 private:
  enum class Part { prefix, header, body, crc };

  std::span<const std::byte> take(std::span<const std::byte>& bytes, std::size_t most);
  void read_prefix(std::span<const std::byte>& bytes);
  void read_header(std::span<const std::byte>& bytes);
  void read_body(std::span<const std::byte>& bytes);
  std::optional<Frame> read_crc(std::span<const std::byte>& bytes);
  void check_magic();
  void check_version();
  void check_lengths();
  void enter(Part part, std::size_t length);
  [[noreturn]] void fail(FrameProblem problem, const std::string& message);

  bool welcomed_ = false;
  std::uint64_t frames_ = 0;
  std::size_t filled_ = 0;  ///< bytes of the present frame that have come
  // The present frame.
  Part part_ = Part::prefix;
  std::size_t part_left_ = prefix_bytes;  ///< bytes of the present part still to come
  std::array<std::byte, prefix_bytes> prefix_{};
  std::array<std::byte, crc_bytes> sent_crc_{};
  std::uint16_t type_ = 0;
  std::size_t header_bytes_ = 0;
  std::size_t body_bytes_ = 0;  ///< of the message's body from this frame on
  std::string header_;
  std::uint32_t crc_ = 0;
  // The message whose body is being gathered.
  Frame gathered_;
  std::size_t body_left_ = 0;  ///< bytes of it to come in frames after those that are here
  std::optional<FrameError> error_;
};

/// One frame ready to be written: head, then body, then crc. The body is the caller's bytes, not a
/// copy.
struct OutFrame {
  std::string head;  ///< prefix and header
  std::span<const std::byte> body;
  std::array<std::byte, crc_bytes> crc{};
  [[nodiscard]] std::size_t size() const { return head.size() + body.size() + crc.size(); }
};

/// The first frame of a message: it carries the first limits::wire_chunk bytes of `body`, or all.
OutFrame first_frame(std::uint16_t type, std::string_view header, std::span<const std::byte> body);
/// The next chunk of a body of which `rest` is not yet sent; not empty.
OutFrame chunk_frame(std::span<const std::byte> rest);
/// A whole message as bytes, chunks and all: for tests, and for what is small.
std::vector<std::byte> frame_bytes(std::uint16_t type, std::string_view header,
                                   std::span<const std::byte> body = {});

}  // namespace tessera::wire
