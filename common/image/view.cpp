#include "common/image/view.hpp"

#include <algorithm>
#include <cmath>

namespace tessera::image {

float seen(View view, float value) {
  if (view == View::srgb) return value;
  constexpr float far = 1e6F;  // the curve has long reached its end, and squares stay finite
  const float x = value > 0 ? std::min(value, far) : 0.0F;  // NaN too
  return std::min(x * (2.51F * x + 0.03F) / (x * (2.43F * x + 0.59F) + 0.14F), 1.0F);
}

void apply_view(View view, double exposure_stops, std::span<float> rgb) {
  const auto scale = static_cast<float>(std::exp2(exposure_stops));
  for (float& value : rgb) value = seen(view, value * scale);
}

}  // namespace tessera::image
