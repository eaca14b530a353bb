#pragma once
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/job/aovs.hpp"

/// Which channels a job's tiles, films and pictures have, when they travel and how they merge.
namespace tessera::image {

using Group = ChannelGroup;
constexpr std::size_t group_count = 2;
using tessera::Merge;

struct Channel {
  std::string name;  ///< in EXR files
  Group group;
  Merge merge;
  int mean_of = -1;  ///< moment2: index of the channel whose squared deviations these are
  bool operator==(const Channel&) const = default;
};

/// The channels of one AOV.
struct AovPlanes {
  AovUse use;
  Group group = Group::aov;
  std::size_t first = 0;  ///< index of the first, the others follow
};

/// The channels of a job, in the order in which planes stand in memory: R G B A M2.R M2.G M2.B,
/// then those of its AOVs that travel with every pass, then the others.
class ChannelLayout {
 public:
  /// Of a job that asks for these AOVs; none: albedo, N, Z. Throws as aov_uses() does.
  explicit ChannelLayout(std::span<const std::string> aovs);

  [[nodiscard]] std::span<const Channel> channels() const { return channels_; }
  [[nodiscard]] std::size_t size() const { return channels_.size(); }
  [[nodiscard]] const Channel& operator[](std::size_t channel) const { return channels_[channel]; }
  [[nodiscard]] std::span<const AovPlanes> aovs() const { return aovs_; }
  /// Of the channel of this name, or −1.
  [[nodiscard]] int index_of(std::string_view name) const;
  /// How many channels, from the first on, travel with a pass: all of them, or those of the beauty
  /// group.
  [[nodiscard]] std::size_t travelling(bool with_aovs) const {
    return with_aovs ? channels_.size() : beauty_;
  }
  /// Their indices in the order in which EXR stores them: by name, as bytes.
  [[nodiscard]] std::span<const std::size_t> by_name(bool with_aovs) const {
    return with_aovs ? all_by_name_ : beauty_by_name_;
  }
  bool operator==(const ChannelLayout& other) const {
    return this == &other || channels_ == other.channels_;
  }

 private:
  std::vector<Channel> channels_;
  std::vector<AovPlanes> aovs_;
  std::size_t beauty_ = 0;  ///< channels that travel with every pass
  std::vector<std::size_t> beauty_by_name_, all_by_name_;
};

/// Shared by all that has a job's channels.
using Layout = std::shared_ptr<const ChannelLayout>;
Layout layout_of(std::span<const std::string> aovs);
/// Of a job that names no AOVs.
const Layout& default_layout();

constexpr float nothing_hit_z = 1e10F;

/// Indices of the channels that code names: the first seven are those of every layout, all of them
/// the default layout's.
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
  channel_count  ///< of the default layout
};

}  // namespace tessera::image
