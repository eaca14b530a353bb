#pragma once
#include <array>
#include <cstdint>
#include <optional>

#include "worker/render/scene.hpp"

namespace tessera::worker {

/// Corners of a parallelogram as vertices of its geometry; the fourth, `across`, should stand at
/// `end_u` + `end_v` − `corner`. Its outer side is where the first three are seen in
/// counter-clockwise order.
struct Parallelogram {
  std::uint32_t corner = 0, end_u = 0, end_v = 0, across = 0;
};

/// The parallelogram that triangle `face` makes with the next one, as quads do that a modeller cut
/// in two: they have an edge in common, look to the same side, and their outer corners lie as they
/// should to within rounding (2⁻²¹ of the largest coordinate before `origin` was subtracted from
/// the positions, and no more than 2⁻¹² of the shortest edge). Nothing where they do not, `face` is
/// the last one, or an edge has no length.
std::optional<Parallelogram> parallelogram(const render::Geometry& geometry, std::uint32_t face,
                                           const std::array<double, 3>& origin = {});

}  // namespace tessera::worker
