#include "worker/render/aov_sums.hpp"

#include <algorithm>

namespace tessera::render {

namespace {

void add(double* sums, const Color& color) {
  sums[0] += color.r;
  sums[1] += color.g;
  sums[2] += color.b;
}

void add(double* sums, const Vec3& vector) {
  sums[0] += vector.x;
  sums[1] += vector.y;
  sums[2] += vector.z;
}

/// One AOV's part of a sample. Those that stand in SampleExtras are only asked for where the record
/// has them.
void add(Aov aov, const SampleRecord& record, double* sums) {
  switch (aov) {
    case Aov::albedo:
      return add(sums, record.albedo);
    case Aov::normal:
      return add(sums, record.normal);
    case Aov::depth:
      *sums = std::min(*sums, static_cast<double>(record.z));
      return;
    case Aov::position:
      return add(sums, record.extras->position);
  }
}

bool in_extras(Aov aov) { return aov != Aov::albedo && aov != Aov::normal && aov != Aov::depth; }

}  // namespace

AovSums::AovSums(const image::ChannelLayout& layout, bool with_aovs)
    : channels_(layout.channels().first(layout.travelling(with_aovs))), sums_(channels_.size()) {
  for (const image::AovPlanes& aov : layout.aovs()) {
    if (aov.group == image::Group::aov && !with_aovs) continue;
    aovs_.push_back(aov);
    wants_extras_ = wants_extras_ || in_extras(aov.use.aov);
  }
}

void AovSums::clear() {
  for (std::size_t c = 0; c < sums_.size(); ++c)
    sums_[c] = channels_[c].merge == Merge::nearest ? static_cast<double>(image::nothing_hit_z) : 0;
}

void AovSums::add(const SampleRecord& record) {
  for (const image::AovPlanes& aov : aovs_)
    render::add(aov.use.aov, record, sums_.data() + aov.first);
}

float AovSums::value(std::size_t channel, std::int64_t count) const {
  const bool mean = channels_[channel].merge == Merge::mean;
  return static_cast<float>(mean ? sums_[channel] / static_cast<double>(count) : sums_[channel]);
}

}  // namespace tessera::render
