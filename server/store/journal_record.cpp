#include "server/store/journal_record.hpp"

#include <bit>
#include <cstring>

#include "common/base/crc32c.hpp"
#include "common/base/error.hpp"
#include "common/base/limits.hpp"

namespace tessera::server {
namespace {

static_assert(std::endian::native == std::endian::little);
constexpr std::size_t identity_most = 255;

class Writer {
 public:
  explicit Writer(std::vector<std::byte>& bytes) : bytes_(bytes) {}
  void raw(std::span<const std::byte> from) {
    bytes_.insert(bytes_.end(), from.begin(), from.end());
  }
  template <class T>
  void number(const T& value) {
    raw(std::as_bytes(std::span(&value, 1)));
  }
  void digest(const Digest& value) { raw(std::as_bytes(std::span(value.bytes))); }
  void text(const std::string& value) {
    number(static_cast<std::uint8_t>(value.size()));
    raw(std::as_bytes(std::span(value)));
  }

 private:
  std::vector<std::byte>& bytes_;
};

class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}
  std::span<const std::byte> raw(std::size_t size) {
    if (size > bytes_.size())
      throw Error(ErrorKind::failed, "a journal record is shorter than its own header");
    const auto piece = bytes_.first(size);
    bytes_ = bytes_.subspan(size);
    return piece;
  }
  template <class T>
  void number(T& value) {
    std::memcpy(&value, raw(sizeof value).data(), sizeof value);
  }
  void digest(Digest& value) {
    std::memcpy(value.bytes.data(), raw(value.bytes.size()).data(), value.bytes.size());
  }
  void text(std::string& value) {
    std::uint8_t size = 0;
    number(size);
    const auto piece = raw(size);
    value.assign(reinterpret_cast<const char*>(piece.data()), piece.size());
  }
  std::span<const std::byte> rest() { return raw(bytes_.size()); }

 private:
  std::span<const std::byte> bytes_;
};

/// All that stands before the EXR, in its order: written by a Writer, read by a Reader.
template <class Stream, class Info>
void pass_through(Stream& stream, Info& info) {
  stream.number(info.job);
  stream.digest(info.plan);
  stream.number(info.task.frame);
  stream.number(info.task.tile);
  stream.number(info.task.pass);
  stream.number(info.lease.epoch);
  stream.number(info.lease.number);
  stream.number(info.samples);
  stream.number(info.rays);
  stream.number(info.rejected);
  stream.number(info.seconds);
  stream.number(info.cpu_seconds);
  stream.text(info.identity);
}

}  // namespace

std::vector<std::byte> record_head(const ResultInfo& info, std::span<const std::byte> exr) {
  if (info.identity.size() > identity_most)
    throw Error(ErrorKind::failed, "a worker's identity is too long to be kept");
  if (exr.size() > limits::wire_body)
    throw Error(ErrorKind::too_large, "a result is too large to be kept");
  constexpr std::size_t usual = 192;
  std::vector<std::byte> head;
  head.reserve(usual);
  Writer out(head);
  out.number(std::uint64_t{0});  // the prefix, when both are known
  pass_through(out, info);
  const auto length = static_cast<std::uint32_t>(head.size() - record_prefix + exr.size());
  const std::uint32_t crc =
      crc32c(exr, crc32c(std::span<const std::byte>(head).subspan(record_prefix)));
  std::memcpy(head.data(), &length, sizeof length);
  std::memcpy(head.data() + sizeof length, &crc, sizeof crc);
  return head;
}

StoredResult parse_record(std::span<const std::byte> bytes) {
  Reader in(bytes);
  std::uint32_t length = 0, crc = 0;
  in.number(length);
  in.number(crc);
  if (length != bytes.size() - record_prefix)
    throw Error(ErrorKind::failed, "a journal record has another length than the index says");
  if (crc != crc32c(bytes.subspan(record_prefix)))
    throw Error(ErrorKind::failed, "a journal record is damaged: its CRC differs");
  StoredResult result;
  pass_through(in, result.info);
  const auto exr = in.rest();
  result.exr.assign(exr.begin(), exr.end());
  return result;
}

}  // namespace tessera::server
