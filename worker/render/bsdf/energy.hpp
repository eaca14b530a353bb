#pragma once
#include <array>
#include <cstddef>

/// What rough surfaces scatter at the first bounce between microfacets, and so what is lost to the
/// later ones: tables made once in a process by a fixed quadrature over visible normals, without
/// libm, so that all machines have the same bits. Making them takes some tens of milliseconds;
/// prepare_…() does it ahead, else the first look-up does. α is that of an isotropic surface; what
/// is brushed in one direction asks brushed_energy.hpp.
namespace tessera::render::energy {

/// Over the cosine of the direction and α, both warped to where the function bends.
template <int Side>
struct Table {
  std::array<float, static_cast<std::size_t>(Side) * static_cast<std::size_t>(Side)> values{};
  /// Where the value of direction `i` and roughness `j` stands.
  static constexpr std::size_t index(int i, int j) {
    return static_cast<std::size_t>(j) * Side + static_cast<std::size_t>(i);
  }
  /// Between two points of an axis.
  struct Place {
    int low;
    float part;  ///< of the next one
    /// 0…1.
    explicit Place(float x) {
      const float at = x * (Side - 1);
      low = at < Side - 2 ? static_cast<int>(at) : Side - 2;
      part = at - static_cast<float>(low);
    }
  };
  [[nodiscard]] float at(const Place& x, const Place& y) const {
    const float* p = &values[index(x.low, y.low)];
    return (p[0] * (1 - x.part) + p[1] * x.part) * (1 - y.part) +
           (p[Side] * (1 - x.part) + p[Side + 1] * x.part) * y.part;
  }
  [[nodiscard]] float at(float x, float y) const { return at(Place(x), Place(y)); }
};

/// Of a surface that reflects everything at its microfacets.
/// The part of the light from a direction that leaves after one bounce; 1 where it is smooth.
float reflection(float cosine, float alpha);
/// The same, and with it the mean of Schlick's (1 − c)^5 over the microfacets at which it bounces.
struct Bounce {
  float albedo = 0;
  float schlick = 0;
};
Bounce bounce(float cosine, float alpha);
/// reflection(), averaged over cosine-weighted directions.
float reflection_mean(float alpha);
void prepare_reflection();

/// Of an interface that absorbs nothing: what leaves, reflected or refracted, after one bounce, of
/// the light from a direction on the side whose index is 1/eta of the other's.
float interface(float cosine, float alpha, float eta);
/// The same, averaged over cosine-weighted directions.
float interface_mean(float alpha, float eta);
void prepare_interface(float eta);

}  // namespace tessera::render::energy
