#pragma once
#include <cstddef>
#include <filesystem>
#include <string>

#include "scenes/generate/noise.hpp"

/// Scenes that are too large to be kept, made when they are needed. The same arguments give the
/// same bytes everywhere: no function of libm but sqrt is used.
namespace tessera::generate {

/// A rock: the unit sphere in the direction `d` (any length), pushed out and in by noise of many
/// scales. 0.7…1.3.
double rock_radius(const Point& d);

/// Writes asteroid.obj and asteroid.json to the folder, which is made if it is not there: a rock of
/// at least `triangles` triangles, all different, over a floor between lamps. Each side of a cube
/// is a grid of squares, pushed out to the sphere. Throws Error{failed} with the file's name.
void write_asteroid(const std::filesystem::path& folder, std::size_t triangles);

/// Squares along each edge of the cube, so that 12·n² is at least `triangles`.
std::size_t grid_side(std::size_t triangles);

}  // namespace tessera::generate
