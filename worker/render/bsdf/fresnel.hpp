#pragma once
#include <cmath>

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

}  // namespace tessera::render
