#include "tests/sim/disk/inode.hpp"

#include <algorithm>
#include <cstring>

namespace tessera::sim {

void Inode::apply(std::vector<std::byte>& to, const Change& change) {
  if (change.cuts) {
    to.resize(change.offset);
    return;
  }
  const std::uint64_t end = change.offset + change.bytes.size();
  if (to.size() < end) to.resize(end);
  std::memcpy(to.data() + change.offset, change.bytes.data(), change.bytes.size());
}

void Inode::write(std::uint64_t offset, std::span<const std::byte> bytes) {
  if (bytes.empty()) return;
  unsynced_.push_back({false, offset, {bytes.begin(), bytes.end()}});
  apply(now_, unsynced_.back());
}

void Inode::truncate(std::uint64_t size) {
  unsynced_.push_back({true, size, {}});
  apply(now_, unsynced_.back());
}

void Inode::sync() {
  for (const Change& change : unsynced_) apply(safe_, change);
  unsynced_.clear();
}

template <class Keep>
std::uint64_t Inode::apply_some(const Change& change, Keep keep) {
  if (change.cuts) {
    if (keep()) apply(safe_, change);
    return 0;
  }
  std::uint64_t lost = 0;
  std::uint64_t from = change.offset;
  const std::uint64_t end = change.offset + change.bytes.size();
  while (from < end) {
    const std::uint64_t to = std::min(end, (from / sector_bytes + 1) * sector_bytes);
    if (keep()) {
      const auto first = change.bytes.begin() + static_cast<std::ptrdiff_t>(from - change.offset);
      apply(safe_, {false, from, {first, first + static_cast<std::ptrdiff_t>(to - from)}});
    } else {
      ++lost;
    }
    from = to;
  }
  return lost;
}

void Inode::fail_sync(Random& random) {
  const double kept = random.unit();
  for (const Change& change : unsynced_) apply_some(change, [&] { return random.chance(kept); });
  unsynced_.clear();
}

std::uint64_t Inode::cut(const CutWeather& weather, Random& random) {
  std::uint64_t lost = 0;
  const std::size_t before = safe_.size();
  std::size_t whole = unsynced_.size();
  if (weather.kind == CutWeather::Kind::in_order)
    whole = static_cast<std::size_t>(random.whole(0, static_cast<std::int64_t>(whole)));
  for (std::size_t i = 0; i < unsynced_.size(); ++i) {
    bool torn = false;
    lost += apply_some(unsynced_[i], [&] {
      switch (weather.kind) {
        case CutWeather::Kind::lost:
          return false;
        case CutWeather::Kind::kept:
          return true;
        case CutWeather::Kind::in_order:
          torn = torn || i > whole || (i == whole && !random.chance(weather.kept));
          return !torn;
        case CutWeather::Kind::any:
          return random.chance(weather.kept);
      }
      return false;
    });
  }
  // The length may have been kept where the bytes were not.
  if (weather.kind == CutWeather::Kind::any && safe_.size() < now_.size() && random.chance(0.5)) {
    const std::size_t end = safe_.size();
    safe_.resize(now_.size());
    if (weather.garbage)
      for (std::size_t i = std::max(before, end); i < safe_.size(); ++i)
        safe_[i] = static_cast<std::byte>(random.next());
  }
  unsynced_.clear();
  now_ = safe_;
  return lost;
}

}  // namespace tessera::sim
