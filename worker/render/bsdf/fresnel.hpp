#pragma once
#include <algorithm>
#include <cmath>

#include "worker/render/vec.hpp"

namespace tessera::render {

struct Fresnel {
  float reflectance = 1;  ///< of unpolarised light; the rest passes
  float cos_transmitted =
      0;  ///< cosine of the refracted direction; 0 under total internal reflection
};

/// Fresnel's equations for a smooth interface between two dielectrics. cos_incident in 0…1; eta is
/// the index on the far side over that on the incident side, > 0 (below 1 it reflects totally
/// beyond the critical angle).
inline Fresnel fresnel_dielectric(float cos_incident, float eta) {
  const float sin2_transmitted = (1 - cos_incident * cos_incident) / (eta * eta);
  if (sin2_transmitted >= 1) return {};
  const float cos_transmitted = std::sqrt(1 - sin2_transmitted);
  const float parallel =
      (eta * cos_incident - cos_transmitted) / (eta * cos_incident + cos_transmitted);
  const float perpendicular =
      (cos_incident - eta * cos_transmitted) / (cos_incident + eta * cos_transmitted);
  return {0.5F * (parallel * parallel + perpendicular * perpendicular), cos_transmitted};
}

/// ((η − 1) / (η + 1))²: along the normal.
constexpr float normal_reflectance(float eta) {
  const float root = (eta - 1) / (eta + 1);
  return root * root;
}

/// Fresnel's equations for a conductor with the complex index η + ik, against air.
inline double fresnel_conductor(double cosine, double eta, double k) {
  const double c2 = cosine * cosine, s2 = 1 - c2, n2 = eta * eta, k2 = k * k;
  const double t = n2 - k2 - s2;
  const double ab = std::sqrt(t * t + 4 * n2 * k2);
  const double a = std::sqrt(std::max(0.0, 0.5 * (ab + t)));
  const double across = (ab + c2 - 2 * a * cosine) / (ab + c2 + 2 * a * cosine);
  const double u = ab * c2 + s2 * s2, v = 2 * a * cosine * s2;
  return 0.5 * across * (1 + (u - v) / (u + v));
}

/// (1 − c)^5, of Schlick's approximation.
constexpr float schlick(float cosine) {
  const float m = 1 - cosine, m2 = m * m;
  return m2 * m2 * m;
}

/// The reflectance of a microfacet, F(c) = normal + rise·(1 − c)^5 − dip·c·(1 − c)^6: Schlick's
/// approximation, with the dip that metals have before grazing angles (Lazányi and Szirmay-Kalos
/// 2005; parametrised at 82° by Kutz, Hašan and Edmondson 2021).
struct Reflectance {
  Color normal, rise, dip;

  /// How much of its rise and of its dip there is at a cosine.
  template <class N>
  struct Parts {
    N rise, dip;
    explicit Parts(N cosine) {
      const N m = within(1.0F - cosine, N(0.0F), N(1.0F)), m2 = m * m, m5 = m2 * m2 * m;
      rise = m5;
      dip = (1.0F - m) * m * m5;
    }
    /// F(c) of one channel.
    [[nodiscard]] N of(N normal_of, N rise_of, N dip_of) const {
      return greater(normal_of + rise_of * rise - dip_of * dip, N(0.0F));
    }
  };
  [[nodiscard]] Color at(float cosine) const {
    const Parts<float> parts(cosine);
    return {parts.of(normal.r, rise.r, dip.r), parts.of(normal.g, rise.g, dip.g),
            parts.of(normal.b, rise.b, dip.b)};
  }
  /// 2∫F(c)·c dc over 0…1.
  [[nodiscard]] Color mean() const { return normal + rise * (1 / 21.0F) - dip * (1 / 126.0F); }
};

/// Schlick's, from `normal` at 0° to `grazing` at 90°.
constexpr Reflectance schlick_reflectance(const Color& normal, const Color& grazing) {
  return {normal, grazing - normal, {}};
}
/// That of a conductor, which it meets at 0°, 82° (cosine 1/7) and 90°.
Reflectance conductor_reflectance(const Color& eta, const Color& k);

}  // namespace tessera::render
