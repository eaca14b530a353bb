#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/image/channels.hpp"
#include "worker/render/record.hpp"

namespace tessera::render {

/// Gathers the AOVs of one pixel's samples of one pass, in index order, in double. One object
/// serves pixel after pixel.
class AovSums {
 public:
  /// Those of `layout` that travel with a pass, with or without those of the AOV group.
  AovSums(const image::ChannelLayout& layout, bool with_aovs);

  /// True if a sample must fill in SampleExtras.
  [[nodiscard]] bool wants_extras() const { return wants_extras_; }
  /// For the next pixel.
  void clear();
  /// Records that are not finite are to be replaced by an empty one before.
  void add(const SampleRecord& record);
  /// The pixel's value in a channel of the layout, rounded once, after `count` samples.
  [[nodiscard]] float value(std::size_t channel, std::int64_t count) const;

 private:
  std::span<const image::Channel> channels_;  ///< that travel
  std::vector<image::AovPlanes> aovs_;
  bool wants_extras_ = false;
  std::vector<double> sums_;  ///< of each channel; of those that are no AOVs unused
};

}  // namespace tessera::render
