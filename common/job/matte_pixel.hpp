#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "common/job/matte.hpp"

namespace tessera {

/// Channels of a Cryptomatte in tiles and films: pairs of an id and its weight, heaviest first,
/// then the weight of all that had no slot.
constexpr std::size_t matte_channels = 2 * matte_slots + 1;

/// What the samples of one pixel saw: an exact map from ids to weights, which are numbers of
/// samples. One object serves pixel after pixel.
class MattePixel {
 public:
  void clear();
  /// An id of 0, and a weight of 0, are nothing.
  void add(double id, double weight);
  /// All that matte channels say.
  void add(std::span<const double, matte_channels> channels);
  /// As channels. Among equal weights the lower id comes first, so that the order in which they
  /// were added has no say. What has no slot is forgotten but for its weight.
  void write(std::span<double, matte_channels> channels);

 private:
  struct Entry {
    double id, weight;
  };
  std::vector<Entry> entries_;
  double evicted_ = 0;
};

}  // namespace tessera
