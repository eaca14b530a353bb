#include "worker/render/bsdf/fresnel.hpp"

namespace tessera::render {

Reflectance conductor_reflectance(const Color& eta, const Color& k) {
  struct Channel {
    float normal, dip;
  };
  const auto channel = [](double n, double extinction) -> Channel {
    constexpr double c = 1.0 / 7, m = 1 - c, m5 = m * m * m * m * m;
    const double normal = fresnel_conductor(1, n, extinction);
    const double schlick_there = normal + (1 - normal) * m5;
    const double dip = (schlick_there - fresnel_conductor(c, n, extinction)) / (c * m5 * m);
    return {static_cast<float>(normal), static_cast<float>(dip)};
  };
  const Channel r = channel(static_cast<double>(eta.r), static_cast<double>(k.r));
  const Channel g = channel(static_cast<double>(eta.g), static_cast<double>(k.g));
  const Channel b = channel(static_cast<double>(eta.b), static_cast<double>(k.b));
  const Color normal{r.normal, g.normal, b.normal};
  return {normal, gray(1) - normal, {r.dip, g.dip, b.dip}};
}

}  // namespace tessera::render
