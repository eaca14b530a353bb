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
  void raw(const void* data, std::size_t size) {
    const auto* from = static_cast<const std::byte*>(data);
    bytes_.insert(bytes_.end(), from, from + size);
  }
  template <class T>
  void number(T value) {
    raw(&value, sizeof value);
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
  T number() {
    T value{};
    std::memcpy(&value, raw(sizeof value).data(), sizeof value);
    return value;
  }
  template <class T>
  void number(T& value) {
    value = number<T>();
  }
  std::span<const std::byte> rest() { return raw(bytes_.size()); }

 private:
  std::span<const std::byte> bytes_;
};

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
  out.number(info.job);
  out.raw(info.plan.bytes.data(), info.plan.bytes.size());
  out.number(info.task.frame);
  out.number(info.task.tile);
  out.number(info.task.pass);
  out.number(info.lease.epoch);
  out.number(info.lease.number);
  out.number(info.samples);
  out.number(info.rays);
  out.number(info.rejected);
  out.number(info.seconds);
  out.number(info.cpu_seconds);
  out.number(static_cast<std::uint8_t>(info.identity.size()));
  out.raw(info.identity.data(), info.identity.size());
  const auto length = static_cast<std::uint32_t>(head.size() - record_prefix + exr.size());
  const std::uint32_t crc =
      crc32c(exr, crc32c(std::span<const std::byte>(head).subspan(record_prefix)));
  std::memcpy(head.data(), &length, sizeof length);
  std::memcpy(head.data() + sizeof length, &crc, sizeof crc);
  return head;
}

StoredResult parse_record(std::span<const std::byte> bytes) {
  Reader in(bytes);
  const auto length = in.number<std::uint32_t>();
  const auto crc = in.number<std::uint32_t>();
  if (length != bytes.size() - record_prefix)
    throw Error(ErrorKind::failed, "a journal record has another length than the index says");
  if (crc != crc32c(bytes.subspan(record_prefix)))
    throw Error(ErrorKind::failed, "a journal record is damaged: its CRC differs");
  StoredResult result;
  ResultInfo& info = result.info;
  in.number(info.job);
  const auto plan = in.raw(info.plan.bytes.size());
  std::memcpy(info.plan.bytes.data(), plan.data(), plan.size());
  in.number(info.task.frame);
  in.number(info.task.tile);
  in.number(info.task.pass);
  in.number(info.lease.epoch);
  in.number(info.lease.number);
  in.number(info.samples);
  in.number(info.rays);
  in.number(info.rejected);
  in.number(info.seconds);
  in.number(info.cpu_seconds);
  const auto identity = in.raw(in.number<std::uint8_t>());
  info.identity.assign(reinterpret_cast<const char*>(identity.data()), identity.size());
  const auto exr = in.rest();
  result.exr.assign(exr.begin(), exr.end());
  return result;
}

}  // namespace tessera::server
