#include "common/wire/framing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "common/base/crc32c.hpp"
#include "common/base/limits.hpp"
#include "common/wire/codec.hpp"

namespace tessera::wire {

namespace {
constexpr std::string_view magic = "TSRA";

template <class T>
T little_endian(std::span<const std::byte> bytes, std::size_t at) {
  T value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i)
    value = static_cast<T>(value | static_cast<T>(std::to_integer<T>(bytes[at + i]) << (8 * i)));
  return value;
}

template <class T>
void put(std::string& out, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i)
    out.push_back(static_cast<char>(static_cast<std::uint8_t>(value >> (8 * i))));
}

std::array<std::byte, crc_bytes> bytes_of(std::uint32_t crc) {
  std::array<std::byte, crc_bytes> bytes{};
  for (std::size_t i = 0; i < crc_bytes; ++i)
    bytes[i] = static_cast<std::byte>(static_cast<std::uint8_t>(crc >> (8 * i)));
  return bytes;
}

std::string printable(std::string_view bytes) {
  std::string out;
  for (const char c : bytes)
    out += c >= ' ' && c <= '~' ? std::string(1, c)
                                : fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
  return out;
}

OutFrame frame(std::uint16_t type, std::string_view header, std::span<const std::byte> body) {
  OutFrame out;
  out.head.reserve(prefix_bytes + header.size());
  out.head += magic;
  put(out.head, protocol_version);
  put(out.head, type);
  put(out.head, static_cast<std::uint32_t>(header.size()));
  put(out.head, static_cast<std::uint32_t>(body.size()));
  out.head += header;
  out.body = body.first(std::min(body.size(), limits::wire_chunk));
  out.crc = bytes_of(crc32c(out.body, crc32c(std::as_bytes(std::span(out.head)))));
  return out;
}
}  // namespace

FrameError::FrameError(FrameProblem problem, const std::string& message)
    : Error(ErrorKind::bad_input, message), problem_(problem) {}

FrameReader::FrameReader() = default;

void FrameReader::fail(FrameProblem problem, const std::string& message) {
  error_.emplace(problem, message);
  throw FrameError(*error_);
}

std::optional<Frame> FrameReader::read(std::span<const std::byte>& bytes) {
  if (error_) throw FrameError(*error_);
  while (!bytes.empty()) {
    switch (part_) {
      case Part::prefix:
        read_prefix(bytes);
        break;
      case Part::header:
        read_header(bytes);
        break;
      case Part::body:
        read_body(bytes);
        break;
      case Part::crc:
        if (std::optional<Frame> whole = read_crc(bytes)) return whole;
        break;
    }
  }
  return std::nullopt;
}

void FrameReader::enter(Part part, std::size_t length) {
  part_ = part;
  part_left_ = length;
}

std::span<const std::byte> FrameReader::take(std::span<const std::byte>& bytes, std::size_t most) {
  const std::span<const std::byte> taken = bytes.first(std::min({bytes.size(), part_left_, most}));
  bytes = bytes.subspan(taken.size());
  part_left_ -= taken.size();
  filled_ += taken.size();
  return taken;
}

void FrameReader::read_prefix(std::span<const std::byte>& bytes) {
  // A field is judged as soon as it is here, so that a stranger who sends a few bytes and waits is
  // known at once.
  const std::size_t at = filled_;
  const std::size_t field_end = at < 4 ? 4 : at < 6 ? 6 : prefix_bytes;
  const std::span<const std::byte> taken = take(bytes, field_end - at);
  std::memcpy(prefix_.data() + at, taken.data(), taken.size());
  if (filled_ != field_end) return;
  if (field_end == 4) check_magic();
  if (field_end == 6) check_version();
  if (field_end != prefix_bytes) return;
  check_lengths();
  crc_ = crc32c(prefix_);
  header_.clear();
  header_.reserve(header_bytes_);
  const std::size_t here = std::min(body_bytes_, limits::wire_chunk);
  if (header_bytes_ > 0) {
    enter(Part::header, header_bytes_);
  } else if (here > 0) {
    enter(Part::body, here);
  } else {
    enter(Part::crc, crc_bytes);
  }
}

void FrameReader::check_magic() {
  std::array<char, 4> found{};
  std::memcpy(found.data(), prefix_.data(), found.size());
  const std::string_view text(found.data(), found.size());
  if (text == magic) return;
  for (const std::string_view method :
       {"GET ", "HEAD", "POST", "PUT ", "DELE", "PATC", "OPTI", "CONN", "TRAC", "PRI ", "HTTP"})
    if (text == method)
      fail(FrameProblem::http,
           "the peer speaks HTTP; this port takes workers, and HTTP has a port of its own");
  if (text[0] == '\x16' && text[1] == '\x03')
    fail(FrameProblem::tls, "the peer begins a TLS handshake; this port does not speak TLS");
  fail(FrameProblem::magic,
       fmt::format("not the worker protocol: a frame begins with \"TSRA\", found \"{}\"",
                   printable(text)));
}

void FrameReader::check_version() {
  const auto version = little_endian<std::uint16_t>(prefix_, 4);
  if (version != protocol_version)
    fail(FrameProblem::version,
         fmt::format("the peer speaks version {} of the worker protocol, this side version {}",
                     version, protocol_version));
}

void FrameReader::check_lengths() {
  type_ = little_endian<std::uint16_t>(prefix_, 6);
  header_bytes_ = little_endian<std::uint32_t>(prefix_, 8);
  body_bytes_ = little_endian<std::uint32_t>(prefix_, 12);
  const bool chunk = type_ == chunk_type;
  if (!chunk && name_of(type_).empty())
    fail(FrameProblem::type, fmt::format("unknown message type {}", type_));
  const std::size_t header_most = chunk       ? 0
                                  : welcomed_ ? limits::wire_header
                                              : limits::wire_header_before_welcome;
  if (header_bytes_ > header_most)
    fail(FrameProblem::too_large,
         fmt::format("a header of {} bytes; at most {} are taken {}", header_bytes_, header_most,
                     chunk       ? "in a chunk"
                     : welcomed_ ? "in a frame"
                                 : "before the welcome"));
  const std::size_t body_most = welcomed_ ? limits::wire_body : 0;
  if (!chunk && body_bytes_ > body_most)
    fail(FrameProblem::too_large,
         fmt::format("a body of {} bytes; at most {} are taken{}", body_bytes_, body_most,
                     welcomed_ ? "" : " before the welcome"));
  if (!chunk && body_bytes_ > 0 && !has_body(type_))
    fail(FrameProblem::type, fmt::format("a {} message has no body, found one of {} bytes",
                                         name_of(type_), body_bytes_));
  if (chunk && (body_left_ == 0 || body_bytes_ != body_left_))
    fail(FrameProblem::order,
         fmt::format("a chunk that says {} bytes of its body are left, where {} are", body_bytes_,
                     body_left_));
  if (!chunk && body_bytes_ > 0 && body_left_ > 0)
    fail(FrameProblem::order,
         fmt::format("a second body begins while {} bytes of the first are left", body_left_));
}

void FrameReader::read_header(std::span<const std::byte>& bytes) {
  const std::span<const std::byte> taken = take(bytes, part_left_);
  crc_ = crc32c(taken, crc_);
  const std::size_t before = header_.size();
  header_.resize(before + taken.size());
  std::memcpy(header_.data() + before, taken.data(), taken.size());
  if (part_left_ > 0) return;
  if (body_bytes_ > 0) {
    enter(Part::body, std::min(body_bytes_, limits::wire_chunk));
  } else {
    enter(Part::crc, crc_bytes);
  }
}

void FrameReader::read_body(std::span<const std::byte>& bytes) {
  // The length was checked; pages that stay empty cost nothing, and the bytes are copied once.
  if (gathered_.body.capacity() < body_bytes_ && gathered_.body.empty())
    gathered_.body.reserve(body_bytes_);
  const std::span<const std::byte> taken = take(bytes, part_left_);
  crc_ = crc32c(taken, crc_);
  gathered_.body.insert(gathered_.body.end(), taken.begin(), taken.end());
  if (part_left_ == 0) enter(Part::crc, crc_bytes);
}

std::optional<Frame> FrameReader::read_crc(std::span<const std::byte>& bytes) {
  const std::size_t at = crc_bytes - part_left_;
  const std::span<const std::byte> taken = take(bytes, part_left_);
  std::memcpy(sent_crc_.data() + at, taken.data(), taken.size());
  if (part_left_ > 0) return std::nullopt;
  if (sent_crc_ != bytes_of(crc_))
    fail(FrameProblem::crc,
         fmt::format("a frame's checksum is {:08x}, its bytes give {:08x}: they were changed on "
                     "their way",
                     little_endian<std::uint32_t>(sent_crc_, 0), crc_));
  ++frames_;
  filled_ = 0;
  enter(Part::prefix, prefix_bytes);
  if (body_bytes_ == 0) return Frame{.type = type_, .header = std::move(header_), .body = {}};
  if (type_ != chunk_type) {
    gathered_.type = type_;
    gathered_.header = std::move(header_);
  }
  body_left_ = body_bytes_ - std::min(body_bytes_, limits::wire_chunk);
  if (body_left_ > 0) return std::nullopt;
  return std::exchange(gathered_, Frame{});
}

OutFrame first_frame(std::uint16_t type, std::string_view header, std::span<const std::byte> body) {
  return frame(type, header, body);
}

OutFrame chunk_frame(std::span<const std::byte> rest) { return frame(chunk_type, {}, rest); }

std::vector<std::byte> frame_bytes(std::uint16_t type, std::string_view header,
                                   std::span<const std::byte> body) {
  std::vector<std::byte> bytes;
  const auto add = [&bytes](std::span<const std::byte> part) {
    bytes.insert(bytes.end(), part.begin(), part.end());
  };
  const auto add_frame = [&add](const OutFrame& out) {
    add(std::as_bytes(std::span(out.head)));
    add(out.body);
    add(out.crc);
  };
  const OutFrame first = first_frame(type, header, body);
  add_frame(first);
  for (std::size_t at = first.body.size(); at < body.size(); at += limits::wire_chunk)
    add_frame(chunk_frame(body.subspan(at)));
  return bytes;
}

}  // namespace tessera::wire
