#include "common/job/aovs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <tuple>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "common/base/names.hpp"
#include "common/job/matte.hpp"

namespace tessera {

namespace {

using enum ChannelGroup;

constexpr std::array table{
    AovEntry{Aov::albedo, "albedo", "RGB", aov, Merge::mean, "what the first surface reflects"},
    AovEntry{Aov::normal, "N", "XYZ", aov, Merge::mean, "its shading normal, in the world"},
    AovEntry{Aov::depth, "Z", "", aov, Merge::nearest, "its distance from the plane of the eye"},
    AovEntry{Aov::position, "P", "XYZ", aov, Merge::mean, "where it is, in the world"},
    AovEntry{Aov::direct, "direct", "RGB", beauty, Merge::mean, "light that scattered once"},
    AovEntry{Aov::indirect, "indirect", "RGB", beauty, Merge::mean,
             "light that scattered more often"},
    AovEntry{Aov::emission, "emission", "RGB", beauty, Merge::mean, "light that did not scatter"},
    AovEntry{Aov::diffuse, "diffuse", "RGB", beauty, Merge::mean,
             "light that the first surface scattered diffusely"},
    AovEntry{Aov::specular, "specular", "RGB", beauty, Merge::mean,
             "light that the first surface reflected otherwise"},
    AovEntry{Aov::transmission, "transmission", "RGB", beauty, Merge::mean,
             "light that came through the first surface"},
    AovEntry{Aov::light, "light_NAME", "RGB", beauty, Merge::mean, "light of one light group"},
    AovEntry{Aov::shadow_catcher, shadow_catcher_aov, "", beauty, Merge::mean,
             "light on shadow catchers, with and without shadows"},
    AovEntry{Aov::uv, "UV", "UV", aov, Merge::mean, "the first surface's texture coordinates"},
    AovEntry{Aov::object_id, "object_id", "", aov, Merge::first, "the first sample's object"},
    AovEntry{Aov::material_id, "material_id", "", aov, Merge::first, "the first sample's material"},
    AovEntry{Aov::crypto_object, "CryptoObject", "", aov, Merge::matte, "Cryptomatte by objects"},
    AovEntry{Aov::crypto_material, "CryptoMaterial", "", aov, Merge::matte,
             "Cryptomatte by materials"},
    AovEntry{Aov::time, "time", "", beauty, Merge::total, "CPU seconds that the samples took"},
    AovEntry{Aov::variance, "variance", "RGB", beauty, Merge::moment2, "in every picture"},
    AovEntry{Aov::samples, "samples", "", beauty, Merge::total, "in every picture"},
};

[[noreturn]] void refuse(const std::string& message) {
  throw Error(ErrorKind::bad_input, message, {.key = "render.aovs"});
}

AovUse use_of(std::string_view name) {
  if (name.starts_with(light_prefix) && is_light_group(name.substr(light_prefix.size())))
    return {Aov::light, std::string(name)};
  const auto* const found = std::find_if(table.begin(), table.end(),
                                         [&](const AovEntry& entry) { return entry.name == name; });
  if (found == table.end()) refuse(unknown_name("AOV", name, aov_names()));
  return {found->aov, std::string(name)};
}

}  // namespace

std::span<const AovEntry> aov_table() { return table; }

std::vector<std::string_view> aov_names() {
  std::vector<std::string_view> names;
  for (const AovEntry& entry : table) names.push_back(entry.name);
  return names;
}

bool is_light_group(std::string_view name) {
  constexpr std::size_t longest = 64;
  const auto fits = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-';
  };
  return !name.empty() && name.size() <= longest && std::all_of(name.begin(), name.end(), fits);
}

std::vector<AovUse> aov_uses(std::span<const std::string> names) {
  std::vector<AovUse> uses;
  if (names.empty())
    for (const AovEntry& entry : std::span(table).first(default_aovs))
      uses.push_back({entry.aov, std::string(entry.name)});
  if (names.size() > limits::aovs_max)
    refuse(fmt::format("expected at most {} names, found {}", limits::aovs_max, names.size()));
  for (const std::string& name : names) uses.push_back(use_of(name));
  const auto order = [](const AovUse& a, const AovUse& b) {
    return std::tie(a.aov, a.name) < std::tie(b.aov, b.name);
  };
  std::sort(uses.begin(), uses.end(), order);
  const auto twice = std::adjacent_find(uses.begin(), uses.end());
  if (twice != uses.end()) refuse(fmt::format("\"{}\" stands there twice", twice->name));
  return uses;
}

namespace {
std::vector<AovChannel> matte_channels_of(const std::string& name) {
  std::vector<AovChannel> out;
  for (std::size_t slot = 0; slot < matte_slots; ++slot) {
    const std::string layer = fmt::format("{}{:02}", name, slot / 2);
    const bool odd = slot % 2 != 0;
    out.push_back({layer + (odd ? ".B" : ".R"), Merge::matte});
    out.push_back({layer + (odd ? ".A" : ".G"), Merge::matte_weight});
  }
  out.push_back({"evicted." + name, Merge::matte_weight});
  return out;
}

/// In the order of CaughtChannel.
std::vector<AovChannel> caught_channels_of(const std::string& name) {
  std::vector<AovChannel> out;
  for (const char* const part :
       {".R", ".G", ".B", ".unshadowed.R", ".unshadowed.G", ".unshadowed.B", ".A"})
    out.push_back({name + part, Merge::mean});
  return out;
}
}  // namespace

std::vector<AovChannel> channels_of(const AovUse& use) {
  if (use.aov == Aov::variance || use.aov == Aov::samples) return {};
  const AovEntry& entry = table.at(static_cast<std::size_t>(use.aov));
  if (entry.merge == Merge::matte) return matte_channels_of(use.name);
  if (use.aov == Aov::shadow_catcher) return caught_channels_of(use.name);
  if (entry.components.empty()) return {{use.name, entry.merge}};
  std::vector<AovChannel> out;
  for (const char component : entry.components)
    out.push_back({use.name + '.' + component, entry.merge});
  return out;
}

std::vector<std::string> with_aov(std::vector<std::string> names, std::string_view needed) {
  if (names.empty())
    for (const AovUse& use : aov_uses(names)) names.push_back(use.name);
  if (std::find(names.begin(), names.end(), needed) == names.end()) names.emplace_back(needed);
  return names;
}

void check_aovs(std::span<const std::string> names, int tile) {
  constexpr std::size_t picture = 7, header = 64 * limits::KiB;
  std::size_t channels = picture;
  for (const AovUse& use : aov_uses(names)) channels += channels_of(use).size();
  const auto side = static_cast<std::size_t>(tile);
  if (side * side * channels * sizeof(float) + header > limits::wire_body)
    throw Error(
        ErrorKind::bad_input,
        fmt::format("a tile of {} by {} with {} channels is larger than the {} bytes that a "
                    "result may have",
                    tile, tile, channels, limits::wire_body),
        {.key = "tile"});
}

std::vector<std::string> names_from(const nlohmann::json& json, const std::string& path) {
  const auto is_text = [](const nlohmann::json& one) { return one.is_string(); };
  if (!json.is_array() || !std::all_of(json.begin(), json.end(), is_text))
    throw Error(ErrorKind::bad_input,
                fmt::format("expected an array of names, found {}", excerpt(json.dump())),
                {.key = path});
  return json.get<std::vector<std::string>>();
}

}  // namespace tessera
