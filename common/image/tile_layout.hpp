#pragma once
#include <array>
#include <cstddef>
#include <span>
#include <string_view>

#include "common/image/channels.hpp"

/// What encoder and decoder of tiles agree on.
namespace tessera::image {

/// The header's attributes with the samples behind each group.
constexpr std::array<std::string_view, group_count> samples_attribute{"tessera.samples.beauty",
                                                                      "tessera.samples.aov"};

/// Indices in channel_table() of the channels that travel, in the order in which EXR stores them:
/// by name, as bytes.
std::span<const std::size_t> travelling_by_name(bool with_aovs);

}  // namespace tessera::image
