#pragma once
#include <array>
#include <string_view>

#include "common/image/channels.hpp"

/// What encoder and decoder of tiles agree on.
namespace tessera::image {

/// The header's attributes with the samples behind each group.
constexpr std::array<std::string_view, group_count> samples_attribute{"tessera.samples.beauty",
                                                                      "tessera.samples.aov"};

}  // namespace tessera::image
