#include "common/job/matte_pixel.hpp"

#include <algorithm>
#include <tuple>

namespace tessera {

void MattePixel::clear() {
  entries_.clear();
  evicted_ = 0;
}

void MattePixel::add(double id, double weight) {
  if (id == 0 || !(weight > 0)) return;
  const auto same = std::find_if(entries_.begin(), entries_.end(),
                                 [&](const Entry& entry) { return entry.id == id; });
  if (same != entries_.end())
    same->weight += weight;
  else
    entries_.push_back({id, weight});
}

void MattePixel::add(std::span<const double, matte_channels> channels) {
  for (std::size_t slot = 0; slot < matte_slots; ++slot)
    add(channels[2 * slot], channels[2 * slot + 1]);
  evicted_ += channels.back();
}

void MattePixel::write(std::span<double, matte_channels> channels) {
  std::sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) {
    return std::tie(b.weight, a.id) < std::tie(a.weight, b.id);
  });
  std::fill(channels.begin(), channels.end(), 0.0);
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    if (i < matte_slots) {
      channels[2 * i] = entries_[i].id;
      channels[2 * i + 1] = entries_[i].weight;
    } else {
      channels.back() += entries_[i].weight;
    }
  }
  channels.back() += evicted_;
}

}  // namespace tessera
