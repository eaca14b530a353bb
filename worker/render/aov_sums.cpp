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
void add(const Gathered& what, const SampleRecord& record, double* sums) {
  const SampleExtras* const extras = record.extras;
  switch (what.aov) {
    case Aov::albedo:
      return add(sums, record.albedo);
    case Aov::normal:
      return add(sums, record.normal);
    case Aov::depth:
      *sums = std::min(*sums, static_cast<double>(record.z));
      return;
    case Aov::position:
      return add(sums, extras->position);
    case Aov::direct:
      return add(sums, extras->direct);
    case Aov::indirect:
      return add(sums, extras->indirect);
    case Aov::emission:
      return add(sums, extras->emission);
    case Aov::diffuse:
      return add(sums, extras->by_lobe.diffuse);
    case Aov::specular:
      return add(sums, extras->by_lobe.specular);
    case Aov::transmission:
      return add(sums, extras->by_lobe.transmission);
    case Aov::light:
      return add(sums, extras->by_group[what.light_group]);
  }
}

bool is_by_lobe(Aov aov) {
  return aov == Aov::diffuse || aov == Aov::specular || aov == Aov::transmission;
}

bool in_extras(Aov aov) { return aov != Aov::albedo && aov != Aov::normal && aov != Aov::depth; }

}  // namespace

AovSums::AovSums(const image::ChannelLayout& layout, bool with_aovs,
                 std::span<const std::string> light_groups)
    : channels_(layout.channels().first(layout.travelling(with_aovs))), sums_(channels_.size()) {
  for (const image::AovPlanes& aov : layout.aovs()) {
    if (aov.group == image::Group::aov && !with_aovs) continue;
    Gathered what{.aov = aov.use.aov, .first = aov.first};
    if (what.aov == Aov::light)
      what.light_group = static_cast<std::size_t>(
          std::find(light_groups.begin(), light_groups.end(), aov.use.light_group()) -
          light_groups.begin());
    aovs_.push_back(what);
    wanted_.extras = wanted_.extras || in_extras(what.aov);
    wanted_.by_lobe = wanted_.by_lobe || is_by_lobe(what.aov);
    wanted_.by_group = wanted_.by_group || what.aov == Aov::light;
  }
}

void AovSums::clear() {
  for (std::size_t c = 0; c < sums_.size(); ++c)
    sums_[c] = channels_[c].merge == Merge::nearest ? static_cast<double>(image::nothing_hit_z) : 0;
}

void AovSums::add(const SampleRecord& record) {
  for (const Gathered& what : aovs_) render::add(what, record, sums_.data() + what.first);
}

float AovSums::value(std::size_t channel, std::int64_t count) const {
  const bool mean = channels_[channel].merge == Merge::mean;
  return static_cast<float>(mean ? sums_[channel] / static_cast<double>(count) : sums_[channel]);
}

}  // namespace tessera::render
