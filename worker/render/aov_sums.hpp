#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/image/channels.hpp"
#include "common/job/matte_pixel.hpp"
#include "worker/render/record.hpp"

namespace tessera::render {

/// One AOV, and where it is gathered.
struct Gathered {
  Aov aov = Aov::albedo;
  std::size_t first = 0;        ///< of its channels
  std::size_t light_group = 0;  ///< Aov::light: which of the scene's
};

/// Gathers the AOVs of one pixel's samples of one pass, in index order, in double. One object
/// serves pixel after pixel.
class AovSums {
 public:
  /// Those of `layout` that travel with a pass, with or without those of the AOV group; of a scene
  /// with these light groups, which are all that it names.
  AovSums(const image::ChannelLayout& layout, bool with_aovs,
          std::span<const std::string> light_groups);

  /// What a sample must fill in.
  struct Wanted {
    bool extras = false;       ///< SampleExtras …
    bool by_lobe = false;      ///< … and their by_lobe,
    bool by_group = false;     ///< and their by_group,
    bool coordinates = false;  ///< uv,
    bool identities = false;   ///< object and material
    bool time = false;         ///< take_time() is to be called
  };
  [[nodiscard]] const Wanted& wanted() const { return wanted_; }
  /// For the next pixel.
  void clear();
  /// Records that are not finite are to be replaced by an empty one before.
  void add(const SampleRecord& record);
  /// How long the pixel's samples took.
  void take_time(double seconds);
  /// After the pixel's last sample, before its values are asked for.
  void finish();
  /// The pixel's value in a channel of the layout, rounded once, after `count` samples.
  [[nodiscard]] float value(std::size_t channel, std::int64_t count) const;

 private:
  void add_identities(const SampleExtras& extras);

  std::span<const image::Channel> channels_;  ///< that travel
  std::vector<Gathered> aovs_;
  Wanted wanted_;
  std::vector<double> sums_;  ///< of each channel; of those that are no AOVs unused
  MattePixel objects_, materials_;
  bool fresh_ = true;  ///< no sample of the pixel yet
};

}  // namespace tessera::render
