#include "worker/render/bsdf/brushed_energy.hpp"

#include <array>
#include <cmath>
#include <mutex>

#include "worker/render/bsdf/energy_quadrature.hpp"
#include "worker/render/float_mode.hpp"

namespace tessera::render::energy {
namespace {

bool is_brushed(const ggx::Roughness& r) { return r.alpha_x != r.alpha_y; }

/// Between two of a table's points.
struct Place {
  std::size_t low = 0;
  float part = 0;  ///< of the next one

  Place(float x, int side) {
    const float at = std::clamp(x, 0.0F, 1.0F) * static_cast<float>(side - 1);
    const int i = std::min(static_cast<int>(at), side - 2);
    low = static_cast<std::size_t>(i);
    part = at - static_cast<float>(i);
  }
};
float between(float a, float b, float part) { return a * (1 - part) + b * part; }

/// One roughness, brushed along x: the greater α is αx.
struct Brushed {
  float along = 1, across = 1;

  /// α as it is seen from an azimuth.
  [[nodiscard]] float seen(float along_x) const {
    return std::sqrt(along * along * along_x + across * across * (1 - along_x));
  }
  /// What happens at grazing angles does so between that and the greater α.
  [[nodiscard]] float warp_cosine(float cosine, float along_x) const {
    return energy::warp_cosine(cosine, std::sqrt(along * seen(along_x)));
  }
  [[nodiscard]] float unwarp_cosine(float x, float along_x) const {
    return energy::unwarp_cosine(x, std::sqrt(along * seen(along_x)));
  }
  /// 0 across the brushing and 1 along it. It follows the α seen, which changes quickly near the
  /// smooth side; there the points lie close.
  [[nodiscard]] float warp_azimuth(float along_x) const {
    return std::sqrt(along_x * (along + across) / (seen(along_x) + across));
  }
  [[nodiscard]] float unwarp_azimuth(float y) const {
    const float part = y * y, at = across + part * (along - across);
    return std::clamp(part * (at + across) / (along + across), 0.0F, 1.0F);
  }
};

/// What one roughness reflects, over cosine and azimuth.
class BrushedTable {
 public:
  void make(const Brushed& brushed) {
    const FlushDenormals mode;
    for (std::size_t j = 0; j < azimuths; ++j) {
      const float along_x = brushed.unwarp_azimuth(coordinate(static_cast<int>(j), azimuths));
      for (std::size_t i = 0; i < cosines; ++i) {
        const float x = coordinate(static_cast<int>(i), cosines);
        const auto bounced = [&](float cosine) {
          const float sine = std::sqrt(std::max(0.0F, 1 - cosine * cosine));
          const Vec3 wo{sine * std::sqrt(along_x), sine * std::sqrt(1 - along_x), cosine};
          return single_bounce(wo, {brushed.along, brushed.across}, whole_circle);
        };
        albedo_[j][i] = bounced(brushed.unwarp_cosine(x, along_x)).albedo;
        schlick_[j][i] = bounced(std::max(x * x, 1e-5F)).schlick;
      }
    }
    mean_ = cosine_mean([&](float cosine) {
      float sum = 0;
      for (int j = 0; j < quarter_parts; ++j) {
        const float x = fast::cos(0.5F * pi * (static_cast<float>(j) + 0.5F) / quarter_parts);
        sum += albedo(brushed.warp_cosine(cosine, x * x), brushed.warp_azimuth(x * x));
      }
      return sum / quarter_parts;
    });
  }
  /// By Brushed's warps.
  [[nodiscard]] float albedo(float x, float y) const { return at(albedo_, x, y); }
  /// x is √cosine.
  [[nodiscard]] float schlick(float x, float y) const { return at(schlick_, x, y); }
  [[nodiscard]] float mean() const { return mean_; }

 private:
  static constexpr int cosines = 20, azimuths = 9, quarter_parts = 16;
  static constexpr NormalGrid whole_circle{.azimuths = 24, .heights = 48, .part = 1};
  using Values = std::array<std::array<float, cosines>, azimuths>;

  static float at(const Values& values, float x, float y) {
    const Place i(x, cosines), j(y, azimuths);
    const auto row = [&](std::size_t k) {
      return between(values[k][i.low], values[k][i.low + 1], i.part);
    };
    return between(row(j.low), row(j.low + 1), j.part);
  }

  Values albedo_, schlick_;
  float mean_ = 0;
};

constexpr int alphas = 20, ratios = 12;

/// The table of a point of the lattice, made when it is first asked for.
const BrushedTable& table_at(std::size_t alpha, std::size_t ratio) {
  static std::array<BrushedTable, std::size_t{alphas} * ratios> tables;
  static std::array<std::once_flag, std::size_t{alphas} * ratios> made;
  const std::size_t at = ratio * alphas + alpha;
  std::call_once(made[at], [&] {
    const float greater = unwarp_alpha(coordinate(static_cast<int>(alpha), alphas));
    const float root = coordinate(static_cast<int>(ratio), ratios);
    tables[at].make({greater, std::max(greater * root * root, alpha_least)});
  });
  return tables[at];
}

/// The four tables about a roughness.
class Lattice {
 public:
  explicit Lattice(const ggx::Roughness& r)
      : brushed_{std::max({r.alpha_x, r.alpha_y, alpha_least}),
                 std::max(std::min(r.alpha_x, r.alpha_y), alpha_least)},
        swapped_(r.alpha_y > r.alpha_x),
        alpha_(warp_alpha(brushed_.along), alphas),
        ratio_(std::sqrt(brushed_.across / brushed_.along), ratios) {}

  [[nodiscard]] float albedo(const Slant& slant) const {
    const float along_x = along(slant), x = brushed_.warp_cosine(slant.cosine, along_x);
    const float y = brushed_.warp_azimuth(along_x);
    return blend([&](const BrushedTable& table) { return table.albedo(x, y); });
  }
  [[nodiscard]] float schlick(const Slant& slant) const {
    const float x = std::sqrt(slant.cosine), y = brushed_.warp_azimuth(along(slant));
    return blend([&](const BrushedTable& table) { return table.schlick(x, y); });
  }
  [[nodiscard]] float mean() const {
    return blend([](const BrushedTable& table) { return table.mean(); });
  }

 private:
  [[nodiscard]] float along(const Slant& slant) const {
    return swapped_ ? 1 - slant.along_x : slant.along_x;
  }
  template <class F>
  [[nodiscard]] float blend(const F& of) const {
    const auto row = [&](std::size_t ratio) {
      return between(of(table_at(alpha_.low, ratio)), of(table_at(alpha_.low + 1, ratio)),
                     alpha_.part);
    };
    return between(row(ratio_.low), row(ratio_.low + 1), ratio_.part);
  }

  Brushed brushed_;
  bool swapped_;
  Place alpha_, ratio_;
};

}  // namespace

Slant slant_of(const Vec3& v) {
  const float sine2 = v.x * v.x + v.y * v.y;
  return {std::min(std::abs(v.z), 1.0F), sine2 > 0 ? std::min(v.x * v.x / sine2, 1.0F) : 0.5F};
}

float reflection(const Vec3& v, const ggx::Roughness& roughness) {
  return is_brushed(roughness) ? Lattice(roughness).albedo(slant_of(v))
                               : reflection(std::min(std::abs(v.z), 1.0F), roughness.alpha_x);
}
Bounce bounce(const Slant& slant, const ggx::Roughness& roughness) {
  if (!is_brushed(roughness)) return bounce(slant.cosine, roughness.alpha_x);
  const Lattice lattice(roughness);
  return {lattice.albedo(slant), lattice.schlick(slant)};
}
float reflection_mean(const ggx::Roughness& roughness) {
  return is_brushed(roughness) ? Lattice(roughness).mean() : reflection_mean(roughness.alpha_x);
}
void prepare_reflection(const ggx::Roughness& roughness) {
  prepare_reflection();
  (void)reflection_mean(roughness);
}

}  // namespace tessera::render::energy
