#include "common/image/channels.hpp"

#include <algorithm>
#include <numeric>

namespace tessera::image {

namespace {

std::vector<Channel> picture_channels() {
  std::vector<Channel> out;
  for (const char* name : {"R", "G", "B", "A"}) out.push_back({name, Group::beauty, Merge::mean});
  for (const int mean : {R, G, B})
    out.push_back(
        {"M2." + out[static_cast<std::size_t>(mean)].name, Group::beauty, Merge::moment2, mean});
  return out;
}

std::vector<std::size_t> sorted_prefix(std::span<const Channel> channels) {
  std::vector<std::size_t> order(channels.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return channels[a].name < channels[b].name; });
  return order;
}

}  // namespace

ChannelLayout::ChannelLayout(std::span<const std::string> aovs) : channels_(picture_channels()) {
  const std::vector<AovUse> uses = aov_uses(aovs);
  for (const Group group : {Group::beauty, Group::aov}) {
    for (const AovUse& use : uses) {
      const AovEntry& entry = aov_table()[static_cast<std::size_t>(use.aov)];
      if (entry.group != group) continue;
      const std::vector<AovChannel> added = channels_of(use);
      if (added.empty()) continue;
      aovs_.push_back({use, group, channels_.size()});
      for (const AovChannel& channel : added)
        channels_.push_back({channel.name, group, channel.merge});
    }
    if (group == Group::beauty) beauty_ = channels_.size();
  }
  beauty_by_name_ = sorted_prefix(channels().first(beauty_));
  all_by_name_ = sorted_prefix(channels());
}

int ChannelLayout::index_of(std::string_view name) const {
  for (std::size_t i = 0; i < channels_.size(); ++i)
    if (channels_[i].name == name) return static_cast<int>(i);
  return -1;
}

Layout layout_of(std::span<const std::string> aovs) {
  return aovs.empty() ? default_layout() : std::make_shared<const ChannelLayout>(aovs);
}

const Layout& default_layout() {
  static const Layout layout =
      std::make_shared<const ChannelLayout>(std::span<const std::string>());
  return layout;
}

}  // namespace tessera::image
