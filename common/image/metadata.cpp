#include "common/image/metadata.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <ctime>
#include <nlohmann/json.hpp>

#include "common/base/build_info.hpp"
#include "common/base/error.hpp"
#include "common/image/exr_layout.hpp"
#include "common/job/aovs.hpp"
#include "common/job/matte.hpp"

namespace tessera::image {

void Metadata::set(std::string_view name, AttributeValue value) {
  constexpr std::size_t longest = 31;
  if (name.empty() || name.size() > longest || is_layout_attribute(name) ||
      name.find('\0') != std::string_view::npos)
    throw Error(ErrorKind::failed, "cannot name an attribute of a picture's header",
                {.key = printable(name)});
  const auto same = [&](const Attribute& attribute) { return attribute.name == name; };
  const auto found = std::find_if(attributes_.begin(), attributes_.end(), same);
  if (found != attributes_.end())
    found->value = std::move(value);
  else
    attributes_.push_back({std::string(name), std::move(value)});
}

const AttributeValue* Metadata::find(std::string_view name) const {
  for (const auto& attribute : attributes_)
    if (attribute.name == name) return &attribute.value;
  return nullptr;
}

namespace {
struct Text {
  std::string operator()(const std::string& text) const { return text; }
  std::string operator()(const Matrix& matrix) const {
    return fmt::format("{}", fmt::join(matrix, " "));
  }
  template <class Number>
  std::string operator()(Number number) const {
    return fmt::format("{}", number);
  }
};
}  // namespace

std::string Metadata::text(std::string_view name) const {
  const AttributeValue* value = find(name);
  return value == nullptr ? std::string() : std::visit(Text{}, *value);
}

namespace {
/// What Cryptomatte's specification wants in a header.
void set_matte(Metadata& metadata, const std::string& layer,
               const std::vector<std::string>& names) {
  const std::string key = fmt::format("cryptomatte/{}/", matte_hex(layer).substr(0, 7));
  metadata.set(key + "name", layer);
  metadata.set(key + "hash", "MurmurHash3_32");
  metadata.set(key + "conversion", "uint32_to_float32");
  if (names.empty()) return;
  nlohmann::json manifest = nlohmann::json::object();
  for (const std::string& name : names) manifest[name] = matte_hex(name);
  metadata.set(key + "manifest", manifest.dump());
}
}  // namespace

Metadata metadata_of(const JobSpec& job, std::int32_t frame) {
  const RenderSettings& render = job.render;
  Metadata metadata;
  metadata.set("software", fmt::format("Tessera {}", version()));
  metadata.set("tessera.job", job.name);
  metadata.set("tessera.scene", job.bundle.hex());
  metadata.set("tessera.camera", job.camera);
  metadata.set("tessera.frame", frame);
  metadata.set("tessera.samples", static_cast<std::int32_t>(render.samples));
  metadata.set("tessera.seed", std::to_string(render.seed));
  metadata.set("tessera.integrator", render.integrator);
  metadata.set("tessera.bounces", static_cast<std::int32_t>(render.bounces));
  metadata.set("tessera.light_samples", static_cast<std::int32_t>(render.light_samples));
  metadata.set("tessera.sampler", render.sampler);
  metadata.set("tessera.filter", render.filter);
  metadata.set("tessera.filter_width", render.filter_width);
  // Clamped light is biased, so whoever opens the file is told.
  if (render.clamp_direct > 0) metadata.set("tessera.clamp_direct", render.clamp_direct);
  if (render.clamp_indirect > 0) metadata.set("tessera.clamp_indirect", render.clamp_indirect);
  metadata.set_pixel_aspect(static_cast<float>(render.pixel_aspect));
  for (const AovUse& use : aov_uses(render.aovs)) {
    if (use.aov == Aov::crypto_object) set_matte(metadata, use.name, job.cryptomatte.objects);
    if (use.aov == Aov::crypto_material) set_matte(metadata, use.name, job.cryptomatte.materials);
  }
  return metadata;
}

void set_date(Metadata& metadata, UnixMillis when) {
  const auto whole = static_cast<std::time_t>(when / 1000);
  std::tm parts{};
  ::gmtime_r(&whole, &parts);
  metadata.set("capDate", fmt::format("{:%Y:%m:%d %H:%M:%S}", parts));
  metadata.set("utcOffset", 0.0F);
}

}  // namespace tessera::image
