#pragma once
#include <cstddef>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// The one table of arbitrary output variables (AOVs): what a job may ask for beside the picture.
namespace tessera {

/// Channels that travel together and share one sample count.
enum class ChannelGroup : std::uint8_t {
  beauty,  ///< every pass
  aov,     ///< passes that bring AOVs: those that end at or before JobSpec::aov_samples
};

/// How a channel's values of several passes become one.
enum class Merge : std::uint8_t {
  mean,  ///< sample-weighted mean, Σ nₖ·meanₖ / Σ nₖ in double, in pass order
  moment2,  ///< Σ (x − mean)²; Chan, Golub and LeVeque's formula in double, in pass order, with the
            ///< mean of `mean_of`
  nearest,  ///< the smaller value; nothing hit is 1e10
  first,    ///< that of the lowest sample index
  total,    ///< Σ in double, in pass order
  /// Cryptomatte, by MattePixel: the ids that most samples saw, …
  matte,
  matte_weight,  ///< … and how many saw each, or none of them; read as shares of the samples
};

/// In the order in which their channels stand in memory.
enum class Aov : std::uint8_t {
  albedo,
  normal,
  depth,
  position,
  direct,
  indirect,
  emission,
  diffuse,
  specular,
  transmission,
  light,  ///< of one light group, which the name says
  shadow_catcher,
  uv,
  object_id,
  material_id,
  crypto_object,
  crypto_material,
  time,
  variance,
  samples
};

struct AovEntry {
  Aov aov;
  std::string_view name;
  /// A letter for each channel, NAME.R and so on; empty: one channel, called NAME. Cryptomattes
  /// and what shadow catchers catch have channels of their own: see channels_of().
  std::string_view components;
  ChannelGroup group;
  Merge merge;
  std::string_view meaning;  ///< a phrase for help
};

/// Indexed by Aov.
std::span<const AovEntry> aov_table();
std::vector<std::string_view> aov_names();

/// What a job that names none asks for.
constexpr std::size_t default_aovs = 3;  ///< the table's first: albedo, N, Z

/// Before the name of a light group in the name of its AOV.
constexpr std::string_view light_prefix = "light_";
/// Aov::shadow_catcher's name.
constexpr std::string_view shadow_catcher_aov = "shadow_catcher";
/// The group of lights that are in no other.
constexpr std::string_view default_light_group = "default";
/// True for what can name a light group: 1 to 64 letters, digits, _ and -.
bool is_light_group(std::string_view name);

/// One that a job asks for.
struct AovUse {
  Aov aov = Aov::albedo;
  std::string name;  ///< under which its channels stand in files
  /// Aov::light's.
  [[nodiscard]] std::string_view light_group() const {
    return std::string_view(name).substr(light_prefix.size());
  }
  bool operator==(const AovUse&) const = default;
};

struct AovChannel {
  std::string name;  ///< in files
  Merge merge = Merge::mean;
};
/// The channels of Aov::shadow_catcher, in order: the light that would leave catchers if they were
/// white, in the shadow of everything and of catchers alone, and the share of samples that saw one.
enum CaughtChannel : std::size_t {
  caught_R,
  caught_G,
  caught_B,
  unshadowed_R,
  unshadowed_G,
  unshadowed_B,
  caught_coverage,
  caught_channel_count
};
/// Those that an AOV adds to a job's; none where every picture has what it names.
std::vector<AovChannel> channels_of(const AovUse& use);

/// What a job that names these asks for, in the table's order. Throws Error{bad_input} at
/// `render.aovs` for a name that is not known, stands there twice, or is one too many.
std::vector<AovUse> aov_uses(std::span<const std::string> names);
/// `names` and one more that a job needs, unless it is among them; where they are none, all that
/// such a job asks for is named.
std::vector<std::string> with_aov(std::vector<std::string> names, std::string_view needed);
/// Throws as aov_uses() does, and at `tile` if a tile with all its channels is more than a result
/// may be.
void check_aovs(std::span<const std::string> names, int tile);

/// An array of names. Throws Error{bad_input} at `path` if `json` is none.
std::vector<std::string> names_from(const nlohmann::json& json, const std::string& path);

}  // namespace tessera
