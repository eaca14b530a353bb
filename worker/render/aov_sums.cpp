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

float number_of(Aov aov, const SampleExtras& extras) {
  return (aov == Aov::object_id ? extras.object : extras.material).number;
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
    case Aov::shadow_catcher:
      add(sums + caught_R, extras->caught.shadowed);
      add(sums + unshadowed_R, extras->caught.unshadowed);
      sums[caught_coverage] += static_cast<double>(extras->caught.coverage);
      return;
    case Aov::uv:
      sums[0] += static_cast<double>(extras->uv.x);
      sums[1] += static_cast<double>(extras->uv.y);
      return;
    case Aov::object_id:
    case Aov::material_id:
    case Aov::crypto_object:
    case Aov::crypto_material:
    case Aov::time:
    case Aov::variance:
    case Aov::samples:
      return;  // not summed
  }
}

bool is_by_lobe(Aov aov) {
  return aov == Aov::diffuse || aov == Aov::specular || aov == Aov::transmission;
}

bool is_identity(Aov aov) {
  return aov == Aov::object_id || aov == Aov::material_id || aov == Aov::crypto_object ||
         aov == Aov::crypto_material;
}

bool in_extras(Aov aov) {
  return aov != Aov::albedo && aov != Aov::normal && aov != Aov::depth && aov != Aov::time;
}

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
    wanted_.coordinates = wanted_.coordinates || what.aov == Aov::uv;
    wanted_.identities = wanted_.identities || is_identity(what.aov);
    wanted_.time = wanted_.time || what.aov == Aov::time;
  }
}

void AovSums::clear() {
  for (std::size_t c = 0; c < sums_.size(); ++c)
    sums_[c] = channels_[c].merge == Merge::nearest ? static_cast<double>(image::nothing_hit_z) : 0;
  objects_.clear();
  materials_.clear();
  fresh_ = true;
}

void AovSums::add(const SampleRecord& record) {
  for (const Gathered& what : aovs_) render::add(what, record, sums_.data() + what.first);
  if (wanted_.identities) add_identities(*record.extras);
}

void AovSums::add_identities(const SampleExtras& extras) {
  for (const Gathered& what : aovs_)
    if (fresh_ && channels_[what.first].merge == Merge::first)
      sums_[what.first] = static_cast<double>(number_of(what.aov, extras));
  fresh_ = false;
  objects_.add(static_cast<double>(extras.object.matte), 1);
  materials_.add(static_cast<double>(extras.material.matte), 1);
}

void AovSums::take_time(double seconds) {
  for (const Gathered& what : aovs_)
    if (what.aov == Aov::time) sums_[what.first] = seconds;
}

void AovSums::finish() {
  for (const Gathered& what : aovs_) {
    if (channels_[what.first].merge != Merge::matte) continue;
    MattePixel& seen = what.aov == Aov::crypto_object ? objects_ : materials_;
    seen.write(std::span(sums_).subspan(what.first).first<matte_channels>());
  }
}

float AovSums::value(std::size_t channel, std::int64_t count) const {
  const bool mean = channels_[channel].merge == Merge::mean;
  return static_cast<float>(mean ? sums_[channel] / static_cast<double>(count) : sums_[channel]);
}

}  // namespace tessera::render
