#pragma once
#include <array>
#include <string_view>

#include "common/scene/material.hpp"

namespace tessera::scene {

/// A metal that a scene can name.
struct Metal {
  std::string_view name;
  Color eta, k;
};

/// Indices were measured by Johnson and Christy (Phys. Rev. B 6, 4370, 1972: gold, copper, silver;
/// Phys. Rev. B 9, 5056, 1974: iron, chromium) and Rakić (Appl. Opt. 34, 4755, 1995: aluminium).
/// Their reflectance at 0° and 82° was integrated from 380 to 780 nm with the CIE 1931 observer (in
/// the fit of Wyman, Sloan and Shirley, JCGT 2013), adapted from illuminant E to D65 (Bradford) and
/// brought to linear Rec.709. η and k here have those reflectances for each colour; they are no
/// measured indices themselves. Gold's red is out of gamut (1.04) and held at .985.
inline constexpr std::array<Metal, 6> metals{{
    {"gold", {0.0626, 0.4883, 1.4723}, {3.9460, 2.2805, 1.7716}},
    {"copper", {0.1814, 1.0305, 1.2972}, {3.4883, 2.6293, 2.3511}},
    {"aluminium", {1.5271, 0.9952, 0.5990}, {7.7014, 6.5753, 5.3242}},
    {"silver", {0.0565, 0.0549, 0.0430}, {4.5216, 3.5627, 2.5658}},
    {"iron", {2.9176, 2.9237, 2.5362}, {3.0827, 2.9406, 2.7443}},
    {"chromium", {3.2387, 3.1265, 2.2718}, {3.2857, 3.3368, 3.1075}},
}};

}  // namespace tessera::scene
