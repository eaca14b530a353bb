#pragma once
#include <algorithm>
#include <cmath>

#include "common/scene/texture.hpp"

namespace tessera::render {

/// A coordinate of any size, brought to where the picture is, [0, 1]. Exact: only whole numbers are
/// subtracted. What is no number, or too large to have a fraction, is 0.
inline float wrapped(float u, scene::Wrap wrap) {
  if (!(std::abs(u) < 0x1p23F)) return 0;
  switch (wrap) {
    case scene::Wrap::repeat:
      return u - std::floor(u);
    case scene::Wrap::mirrored_repeat: {
      const float within = u - 2 * std::floor(0.5F * u);
      return within > 1 ? 2 - within : within;
    }
    case scene::Wrap::clamp_to_edge:
      break;
  }
  return std::clamp(u, 0.0F, 1.0F);
}

/// The texel beside the picture that a wrapped coordinate's neighbour is: −1 ≤ index ≤ size.
inline int wrapped_index(int index, int size, scene::Wrap wrap) {
  if (index < 0) return wrap == scene::Wrap::repeat ? size - 1 : 0;
  if (index >= size) return wrap == scene::Wrap::repeat ? 0 : size - 1;
  return index;
}

}  // namespace tessera::render
