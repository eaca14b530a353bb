#include "common/image/channels.hpp"

#include <array>

namespace tessera::image {

namespace {
constexpr std::array<Channel, channel_count> table{{
    {"R", Group::beauty, Merge::mean},
    {"G", Group::beauty, Merge::mean},
    {"B", Group::beauty, Merge::mean},
    {"A", Group::beauty, Merge::mean},
    {"M2.R", Group::beauty, Merge::moment2, R},
    {"M2.G", Group::beauty, Merge::moment2, G},
    {"M2.B", Group::beauty, Merge::moment2, B},
    {"albedo.R", Group::aov, Merge::mean},
    {"albedo.G", Group::aov, Merge::mean},
    {"albedo.B", Group::aov, Merge::mean},
    {"N.X", Group::aov, Merge::mean},
    {"N.Y", Group::aov, Merge::mean},
    {"N.Z", Group::aov, Merge::mean},
    {"Z", Group::aov, Merge::nearest},
}};

constexpr std::size_t beauty_channels() {
  std::size_t count = 0;
  while (count < table.size() && table[count].group == Group::beauty) ++count;
  return count;
}
static_assert(beauty_channels() == albedo_R,
              "channels of the beauty group are a prefix of the table");
}  // namespace

std::span<const Channel> channel_table() { return table; }

int channel_index(std::string_view name) {
  for (std::size_t i = 0; i < table.size(); ++i)
    if (table[i].name == name) return static_cast<int>(i);
  return -1;
}

std::size_t channels_travelling(bool with_aovs) {
  return with_aovs ? table.size() : beauty_channels();
}

}  // namespace tessera::image
