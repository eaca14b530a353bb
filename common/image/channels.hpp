#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

/// The one table that says which channels there are, when they travel and how they merge.
namespace tessera::image {

/// Channels that travel together and share one sample count.
enum class Group : std::uint8_t {
  beauty,  ///< every pass
  aov,     ///< passes that bring AOVs
};
constexpr std::size_t group_count = 2;

enum class Merge : std::uint8_t {
  mean,  ///< sample-weighted mean, Σ nₖ·meanₖ / Σ nₖ in double, in pass order
  moment2,  ///< Σ (x − mean)²; Chan, Golub and LeVeque's formula in double, in pass order, with the
            ///< mean of `mean_of`
  nearest,  ///< the smaller value; nothing hit is 1e10
};

struct Channel {
  std::string_view name;  ///< in EXR files
  Group group;
  Merge merge;
  int mean_of = -1;  ///< moment2: index of the channel whose squared deviations these are
};

/// In the order in which planes stand in memory: R G B A M2.R M2.G M2.B albedo.R albedo.G albedo.B
/// N.X N.Y N.Z Z.
std::span<const Channel> channel_table();
/// Index in the table, or −1.
int channel_index(std::string_view name);
/// How many channels of the table (a prefix of it) travel with a pass: all of them, or those of the
/// beauty group.
std::size_t channels_travelling(bool with_aovs);

constexpr float nothing_hit_z = 1e10F;

// Indices of the channels that code names.
enum ChannelIndex : std::size_t {
  R,
  G,
  B,
  A,
  M2_R,
  M2_G,
  M2_B,
  albedo_R,
  albedo_G,
  albedo_B,
  N_X,
  N_Y,
  N_Z,
  Z,
  channel_count
};

}  // namespace tessera::image
