#pragma once
#include <array>
#include <vector>

#include "common/image/picture.hpp"

/// How far two renderers' pictures of one scene agree.
namespace tessera::peer {

/// One picture moved, and made larger from its middle, until it lies on the other as well as it
/// can: what a difference between cameras comes to.
struct Framing {
  double right = 0, down = 0;  ///< pixels by which the first lies off the second
  double larger = 0;           ///< what its scale has beyond 1
};

/// Means over squares of pixels, compared.
struct Blocks {
  double median = 0, most = 0;  ///< |difference| over the second's, of luminance
  int x = 0, y = 0;             ///< upper left pixel of the block that differs most
};

struct Likeness {
  std::array<double, 3> first{}, second{};  ///< means of R, G, B
  double rel_mse = 0;  ///< mean of (a−b)²/(b²+ε), ε a hundredth of the second's squared mean
  Framing framing;
  Blocks blocks;
};

constexpr int block_side = 8;  ///< pixels

/// Both have R, G, B and one size; throws Error{bad_input} else.
Likeness compare(const image::ExrImage& first, const image::ExrImage& second);

/// Both pictures side by side, at an exposure that puts the second's mean at a mid grey, and their
/// difference over their sum: red where the first is brighter, blue where it is darker, full at a
/// half. A PNG file.
std::vector<std::byte> side_by_side(const image::ExrImage& first, const image::ExrImage& second);

}  // namespace tessera::peer
