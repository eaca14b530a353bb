#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

/// What generated scenes are made of. The same arguments give the same bytes everywhere: no
/// function of libm but sqrt is used.
namespace tessera::generate {

using Point = std::array<double, 3>;

/// A value for a whole point, −1…1 (the finaliser of MurmurHash3 over its coordinates).
double lattice(std::int64_t x, std::int64_t y, std::int64_t z);
/// A smooth pseudo-random function of space, −1…1: values at whole points, blended in between.
double noise(const Point& p);

Point unit(const Point& v);
/// Cosine and sine of so many turns.
std::array<double, 2> on_circle(double turns);
/// Point (i, j) of side `side` of the cube [−1, 1]³, n squares along an edge, counter-clockwise
/// seen from outside.
Point on_cube(int side, std::size_t i, std::size_t j, std::size_t n);

}  // namespace tessera::generate
