#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <utility>

namespace tessera::image {

/// How linear light becomes a screen's, before its values are encoded in sRGB.
enum class View : std::uint8_t {
  srgb,   ///< as it is; what is beyond 1 is cut off
  filmic  ///< by a curve that lets highlights run out softly: x(2.51x + 0.03)/(x(2.43x + 0.59) +
          ///< 0.14) of each channel, the fit of ACES' transforms in K. Narkowicz, "ACES Filmic Tone
          ///< Mapping Curve" (2015)
};
constexpr std::array<std::pair<std::string_view, View>, 2> view_names{
    {{"srgb", View::srgb}, {"filmic", View::filmic}}};

/// One channel's value, of whatever size: 0…1 by the filmic view, unchanged by the other.
float seen(View view, float value);
/// Multiplies by 2^exposure_stops, then applies the view.
void apply_view(View view, double exposure_stops, std::span<float> rgb);

}  // namespace tessera::image
