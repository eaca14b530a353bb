#include "worker/render/bsdf/energy.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "worker/render/bsdf/energy_quadrature.hpp"
#include "worker/render/bsdf/fresnel.hpp"
#include "worker/render/bsdf/ggx.hpp"
#include "worker/render/float_mode.hpp"

namespace tessera::render::energy {
namespace {

Vec3 direction(float cosine) { return {std::sqrt(std::max(0.0F, 1 - cosine * cosine)), 0, cosine}; }

/// One number for each row of a table.
template <int Side>
struct Means {
  std::array<float, static_cast<std::size_t>(Side)> values{};
  [[nodiscard]] float at(float y) const {
    const float f = y * (Side - 1);
    const int j = f < Side - 2 ? static_cast<int>(f) : Side - 2;
    const float b = f - static_cast<float>(j);
    const auto row = static_cast<std::size_t>(j);
    return values[row] * (1 - b) + values[row + 1] * b;
  }
};

Bounce computed_bounce(float cosine, float alpha) {
  return single_bounce(direction(cosine), {alpha, alpha}, {.azimuths = 16, .heights = 64});
}

struct Reflection {
  Table<reflection_side> albedo, schlick;
  Means<reflection_side> mean;

  Reflection() {
    const FlushDenormals mode;
    constexpr int side = reflection_side;
    for (int j = 0; j < side; ++j) {
      const float alpha = unwarp_alpha(coordinate(j, side));
      for (int i = 0; i < side; ++i) {
        const std::size_t at = Table<side>::index(i, j);
        const float x = coordinate(i, side);
        albedo.values[at] = computed_bounce(unwarp_cosine(x, alpha), alpha).albedo;
        schlick.values[at] = computed_bounce(std::max(x * x, 1e-5F), alpha).schlick;
      }
      const float y = coordinate(j, side);
      mean.values[static_cast<std::size_t>(j)] =
          cosine_mean([&](float c) { return albedo.at(warp_cosine(c, alpha), y); });
    }
  }
};

const Reflection& reflection_tables() {
  static const Reflection tables;
  return tables;
}

/// Interfaces are tabulated at steps of the index, each when it is first asked for; 1.5 stands on a
/// step.
struct Interface {
  static constexpr int side = 20;
  Table<side> from_thin, from_dense;
  Means<side> mean_thin, mean_dense;

  void make(float eta) {
    const FlushDenormals mode;
    fill(from_thin, mean_thin, eta);
    fill(from_dense, mean_dense, 1 / eta);
  }

 private:
  static void fill(Table<side>& table, Means<side>& mean, float eta) {
    for (int j = 0; j < side; ++j) {
      const float y = coordinate(j, side), alpha = unwarp_alpha(y);
      for (int i = 0; i < side; ++i) {
        table.values[Table<side>::index(i, j)] =
            single_bounce(unwarp_cosine(coordinate(i, side), alpha), alpha, eta);
      }
      mean.values[static_cast<std::size_t>(j)] =
          cosine_mean([&](float c) { return table.at(warp_cosine(c, alpha), y); });
    }
  }
  static float single_bounce(float cosine, float alpha, float eta) {
    const Vec3 wo = direction(cosine);
    const ggx::Roughness roughness{alpha, alpha};
    const auto leaves = [&](const Vec3& m) -> std::array<float, 2> {
      const float c = std::clamp(dot(wo, m), 0.0F, 1.0F);
      const Fresnel fresnel = fresnel_dielectric(c, eta);
      float sum = 0;
      const Vec3 up = mirrored(wo, m);
      if (up.z > 0) sum += fresnel.reflectance * ggx::masking_ratio(roughness, wo, up);
      const Vec3 down = m * (c / eta - fresnel.cos_transmitted) - wo / eta;
      if (fresnel.reflectance < 1 && down.z < 0) {
        sum += (1 - fresnel.reflectance) * ggx::masking_ratio(roughness, wo, down);
      }
      return {sum, 0};
    };
    const NormalGrid grid{.azimuths = 12, .heights = 40};
    return mean_over_normals(wo, roughness, grid, leaves)[0];
  }
};

// Finer where the indices are alike: the step of number k has |η − 1| / (η + 1) = (k/10)²/5.
constexpr int interface_steps = 23;
float step_of(float root) { return 10 * std::sqrt(5 * root); }
float root_of(int step) { return static_cast<float>(step * step) * (0.2F / 100); }

/// The table of one step, made when it is first asked for.
const Interface& interface_at(int step) {
  static std::array<Interface, interface_steps> tables;
  static std::array<std::once_flag, interface_steps> made;
  const auto i = static_cast<std::size_t>(step);
  std::call_once(made[i], [&] {
    // At η = 1 microfacets bend nothing, and reach no other direction: a little more.
    const float root = std::max(root_of(step), 5e-4F);
    tables[i].make((1 + root) / (1 - root));
  });
  return tables[i];
}

struct Steps {
  const Interface& low;
  const Interface& high;
  float part;  ///< of the high one
};
Steps steps_for(float eta) {
  const float at = std::min(step_of(std::abs(eta - 1) / (eta + 1)), interface_steps - 1.0F);
  const int low = std::min(static_cast<int>(at), interface_steps - 2);
  return {interface_at(low), interface_at(low + 1), at - static_cast<float>(low)};
}

template <class N>
N reflection_of(N cosine, N alpha) {
  return reflection_tables().albedo.at(warp_cosine(cosine, greater(alpha, N(alpha_least))),
                                       warp_alpha(alpha));
}

}  // namespace

float reflection(float cosine, float alpha) { return reflection_of(cosine, alpha); }
WideFloat reflection(const WideFloat& cosine, const WideFloat& alpha) {
  return reflection_of(cosine, alpha);
}
Bounce bounce(float cosine, float alpha) {
  const Reflection& tables = reflection_tables();
  const BouncePlaces x(cosine, std::max(alpha, alpha_least));
  const Table<reflection_side>::Place<float> y(warp_alpha(alpha));
  return {tables.albedo.at(x.albedo, y), tables.schlick.at(x.schlick, y)};
}
BounceRow::BounceRow(float alpha) : alpha_(std::max(alpha, alpha_least)) {
  const FlushDenormals mode;
  const Reflection& tables = reflection_tables();
  const Place y(warp_alpha(alpha));
  const auto fill = [&](const Table<reflection_side>& table, Values& row) {
    for (int i = 0; i < reflection_side; ++i)
      row[static_cast<std::size_t>(i)] = table.at_point(i, y);
  };
  fill(tables.albedo, albedo_);
  fill(tables.schlick, schlick_);
}
float reflection_mean(float alpha) { return reflection_tables().mean.at(warp_alpha(alpha)); }
void prepare_reflection() { (void)reflection_tables(); }

float interface(float cosine, float alpha, float eta) {
  const Steps steps = steps_for(eta);
  const float x = warp_cosine(cosine, std::max(alpha, alpha_least)), y = warp_alpha(alpha);
  const auto of = [&](const Interface& one) {
    return eta >= 1 ? one.from_thin.at(x, y) : one.from_dense.at(x, y);
  };
  return of(steps.low) * (1 - steps.part) + of(steps.high) * steps.part;
}
float interface_mean(float alpha, float eta) {
  const Steps steps = steps_for(eta);
  const float y = warp_alpha(alpha);
  const auto of = [&](const Interface& one) {
    return eta >= 1 ? one.mean_thin.at(y) : one.mean_dense.at(y);
  };
  return of(steps.low) * (1 - steps.part) + of(steps.high) * steps.part;
}
void prepare_interface(float eta) { (void)steps_for(eta); }

}  // namespace tessera::render::energy
