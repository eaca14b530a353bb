#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "common/image/channels.hpp"
#include "worker/render/record.hpp"

namespace tessera::render {

/// Gathers the picture of one pixel's samples of one pass, in index order, in double.
class PixelSums {
 public:
  /// Records that are not finite are to be replaced by an empty one before.
  void add(const SampleRecord& record) {
    const std::array<double, 3> rgb{record.radiance.r, record.radiance.g, record.radiance.b};
    if (count_ == 0) first_ = rgb;
    ++count_;
    for (std::size_t c = 0; c < 3; ++c) {
      mean_[c] += rgb[c];
      // About the first sample, not about 0: then the sum of squares is at most n + 1 times the
      // second moment about the mean, so what cancels below is n + 1 roundings of a double at the
      // most.
      const double off = rgb[c] - first_[c];
      off_[c] += off;
      square_[c] += off * off;
    }
    mean_[3] += record.alpha;
  }

  /// The pixel's value in `channel`, one of R … M2.B, rounded once.
  [[nodiscard]] float value(std::size_t channel) const {
    const double n = static_cast<double>(count_);
    if (channel <= image::A) return static_cast<float>(mean_[channel] / n);
    const std::size_t c = channel - image::M2_R;
    return static_cast<float>(std::max(0.0, square_[c] - off_[c] * off_[c] / n));
  }

 private:
  std::array<double, 4> mean_{};
  std::array<double, 3> first_{}, off_{}, square_{};
  std::int64_t count_ = 0;
};

}  // namespace tessera::render
