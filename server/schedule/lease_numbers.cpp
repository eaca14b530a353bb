#include "server/schedule/lease_numbers.hpp"

#include <bit>
#include <cstring>

namespace tessera::server {
namespace {

constexpr int seal_bits = 24;
constexpr std::uint64_t seal_mask = (std::uint64_t{1} << seal_bits) - 1;

struct SipState {
  std::uint64_t v0, v1, v2, v3;

  void round() {
    v0 += v1, v1 = std::rotl(v1, 13), v1 ^= v0, v0 = std::rotl(v0, 32);
    v2 += v3, v3 = std::rotl(v3, 16), v3 ^= v2;
    v0 += v3, v3 = std::rotl(v3, 21), v3 ^= v0;
    v2 += v1, v1 = std::rotl(v1, 17), v1 ^= v2, v2 = std::rotl(v2, 32);
  }
  void word(std::uint64_t m) {
    v3 ^= m;
    round();
    round();
    v0 ^= m;
  }
};

std::uint64_t little_endian(const std::uint8_t* bytes, std::size_t count) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < count; ++i) value |= std::uint64_t{bytes[i]} << (8 * i);
  return value;
}

}  // namespace

std::uint64_t siphash(const std::array<std::uint8_t, 16>& key,
                      std::span<const std::uint8_t> bytes) {
  const std::uint64_t k0 = little_endian(key.data(), 8), k1 = little_endian(key.data() + 8, 8);
  SipState state{k0 ^ 0x736f6d6570736575ULL, k1 ^ 0x646f72616e646f6dULL, k0 ^ 0x6c7967656e657261ULL,
                 k1 ^ 0x7465646279746573ULL};
  std::size_t at = 0;
  for (; at + 8 <= bytes.size(); at += 8) state.word(little_endian(bytes.data() + at, 8));
  state.word((std::uint64_t{bytes.size()} << 56) |
             little_endian(bytes.data() + at, bytes.size() - at));
  state.v2 ^= 0xff;
  for (int i = 0; i < 4; ++i) state.round();
  return state.v0 ^ state.v1 ^ state.v2 ^ state.v3;
}

LeaseNumbers::LeaseNumbers(std::uint64_t epoch, const std::array<std::uint8_t, 16>& key)
    : epoch_(epoch), key_(key) {}

LeaseId LeaseNumbers::next(std::string_view identity, JobId job, const TaskId& task) {
  ++count_;
  return {epoch_, (count_ << seal_bits) | seal(epoch_, count_, identity, job, task)};
}

bool LeaseNumbers::granted(const LeaseId& lease, std::string_view identity, JobId job,
                           const TaskId& task) const {
  const std::uint64_t count = lease.number >> seal_bits;
  if (lease.epoch > epoch_ || count == 0 || (lease.epoch == epoch_ && count > count_)) return false;
  return (lease.number & seal_mask) == seal(lease.epoch, count, identity, job, task);
}

std::uint64_t LeaseNumbers::seal(std::uint64_t epoch, std::uint64_t count,
                                 std::string_view identity, JobId job, const TaskId& task) const {
  const std::span<const std::uint8_t> name(reinterpret_cast<const std::uint8_t*>(identity.data()),
                                           identity.size());
  const std::array<std::uint64_t, 6> words{
      epoch,
      count,
      siphash(key_, name),
      job,
      (std::uint64_t{static_cast<std::uint32_t>(task.frame)} << 32) | task.tile,
      task.pass};
  std::array<std::uint8_t, sizeof words> bytes{};
  std::memcpy(bytes.data(), words.data(), sizeof words);
  return siphash(key_, bytes) & seal_mask;
}

}  // namespace tessera::server
