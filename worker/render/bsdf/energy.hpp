#pragma once
#include <array>
#include <cstddef>

#include "worker/render/wide.hpp"

/// What rough surfaces scatter at the first bounce between microfacets, and so what is lost to the
/// later ones: tables made once in a process by a fixed quadrature over visible normals, without
/// libm, so that all machines have the same bits. Making them takes some tens of milliseconds;
/// prepare_…() does it ahead, else the first look-up does. α is that of an isotropic surface; what
/// is brushed in one direction asks brushed_energy.hpp.
namespace tessera::render::energy {

constexpr float alpha_least = 1e-4F;

/// At low α all that happens does so where the cosine is like α: there a table's axis is stretched.
template <class N>
N warp_cosine(N cosine, N alpha) {
  return square_root(lesser(N(1.0F), cosine * (1.0F + 2.0F * alpha) / (cosine + 2.0F * alpha)));
}
template <class N>
N warp_alpha(N alpha) {
  return square_root(within(alpha, N(0.0F), N(1.0F)));
}

/// Over the cosine of the direction and α, both warped to where the function bends.
template <int Side>
struct Table {
  std::array<float, static_cast<std::size_t>(Side) * static_cast<std::size_t>(Side)> values{};
  /// Where the value of direction `i` and roughness `j` stands.
  static constexpr std::size_t index(int i, int j) {
    return static_cast<std::size_t>(j) * Side + static_cast<std::size_t>(i);
  }
  /// Between two points of an axis.
  template <class N>
  struct Place {
    N low;   ///< which is the lower one: a whole number, so that lanes need no integers
    N part;  ///< of the next one
    /// 0…1.
    explicit Place(N x) {
      constexpr auto last = static_cast<float>(Side - 2);
      const N at = x * static_cast<float>(Side - 1);
      low = whole_part(select(at < last, at, N(last)));
      part = at - low;
    }
    [[nodiscard]] N between(N here, N next) const { return here * (1.0F - part) + next * part; }
  };
  [[nodiscard]] float at(const Place<float>& x, const Place<float>& y) const {
    const float* p = &values[index(static_cast<int>(x.low), static_cast<int>(y.low))];
    return between(x, y, p[0], p[1], p[Side], p[Side + 1]);
  }
  [[nodiscard]] float at(float x, float y) const { return at(Place<float>(x), Place<float>(y)); }
  /// At a point of the first axis.
  [[nodiscard]] float at_point(int i, const Place<float>& y) const {
    const float* p = &values[index(i, static_cast<int>(y.low))];
    return y.between(p[0], p[Side]);
  }
  [[nodiscard]] WideFloat at(const WideFloat& x_at, const WideFloat& y_at) const {
    const Place<WideFloat> x(x_at), y(y_at);
    WideFloat a, b, c, d;
    for (std::size_t lane = 0; lane < WideFloat::lanes; ++lane) {
      const float* p = &values[index(static_cast<int>(x.low[lane]), static_cast<int>(y.low[lane]))];
      a.set(lane, p[0]);
      b.set(lane, p[1]);
      c.set(lane, p[Side]);
      d.set(lane, p[Side + 1]);
    }
    return between(x, y, a, b, c, d);
  }

 private:
  template <class N>
  static N between(const Place<N>& x, const Place<N>& y, N a, N b, N c, N d) {
    return x.between(y.between(a, c), y.between(b, d));
  }
};

/// Of a surface that reflects everything at its microfacets.
/// The part of the light from a direction that leaves after one bounce; 1 where it is smooth.
float reflection(float cosine, float alpha);
WideFloat reflection(const WideFloat& cosine, const WideFloat& alpha);
/// The same, and with it the mean of Schlick's (1 − c)^5 over the microfacets at which it bounces.
struct Bounce {
  float albedo = 0;
  float schlick = 0;
};
Bounce bounce(float cosine, float alpha);
/// The tables' points along each axis.
inline constexpr int reflection_side = 32;
/// Where the two numbers of a bounce stand along the axis of the direction; α at least alpha_least.
struct BouncePlaces {
  Table<reflection_side>::Place<float> albedo, schlick;
  BouncePlaces(float cosine, float alpha)
      : albedo(warp_cosine(cosine, alpha)), schlick(square_root(lesser(cosine, 1.0F))) {}
};
/// bounce() at one α, in less time, with its bits.
class BounceRow {
 public:
  explicit BounceRow(float alpha);
  [[nodiscard]] Bounce at(float cosine) const {
    const BouncePlaces at(cosine, alpha_);
    return {value(albedo_, at.albedo), value(schlick_, at.schlick)};
  }

 private:
  using Place = Table<reflection_side>::Place<float>;
  using Values = std::array<float, reflection_side>;
  static float value(const Values& values, const Place& x) {
    const auto low = static_cast<std::size_t>(static_cast<int>(x.low));
    return x.between(values[low], values[low + 1]);
  }
  float alpha_;
  Values albedo_{}, schlick_{};
};
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
