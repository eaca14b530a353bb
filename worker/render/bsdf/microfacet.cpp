#include "worker/render/bsdf/microfacet.hpp"

#include <algorithm>
#include <cmath>

#include "worker/render/bsdf/brushed_energy.hpp"
#include "worker/render/warp.hpp"

namespace tessera::render::microfacet {
namespace {

/// The reflectance of all bounces after the first, where `mean` is one bounce's and `energy` what
/// escapes at each: Σ mean^(n+1)·energy·(1 − energy)^(n−1).
Color later_bounces(const Color& mean, float energy) {
  const auto of = [energy](float f) { return f * f * energy / (1 - f * (1 - energy)); };
  return {of(mean.r), of(mean.g), of(mean.b)};
}

struct Sides {
  Vec3 wo, wi;  ///< both turned up
  bool meet = false;
};
/// Turned so that the lobe only ever reflects upwards.
Sides turned_up(const Lobe& lobe, const Vec3& wo, const Vec3& wi) {
  const bool through = lobe.kind == LobeKind::microfacet_through;
  const bool same = wo.z * wi.z > 0;
  Sides out{wo, wi, through ? wo.z * wi.z < 0 : same};
  out.wo.z = std::abs(wo.z);
  out.wi.z = std::abs(wi.z);
  return out;
}

/// Light that bounces once between microfacets; both directions are up.
template <class N>
struct Once {
  N factor;  ///< of the value, beside the reflectance at the cosine
  N cosine;  ///< at the microfacet
  N pdf;
  Once(const ggx::BasicRoughness<N>& roughness, const Vector3<N>& wo, const Vector3<N>& wi) {
    const Vector3<N> m = normalize(wo + wi);
    const N quarter = ggx::distribution(roughness, m) * 0.25F;
    factor = quarter * ggx::masking_over_cosines(roughness, wo, wi) * wi.z;
    cosine = dot(wo, m);
    pdf = quarter * ggx::masking_over_cosine(roughness, wo);
  }
};
/// The density where what bounced more than once is drawn with the chance `share`.
template <class N>
N pdf_of_all(N share, N once, N cosine) {
  return (1.0F - share) * once + share * inv_pi * cosine;
}

Reflectance reflectance_of(const Lobe& lobe) {
  return lobe.kind == LobeKind::microfacet ? Reflectance{lobe.weight, lobe.tint, lobe.dip}
                                           : Reflectance{lobe.weight, {}, {}};
}

}  // namespace

Surface surface_of(const Reflectance& reflectance, const ggx::Roughness& roughness) {
  Surface out{.reflectance = reflectance,
              .roughness = roughness,
              .smooth = ggx::is_smooth(roughness),
              .later = {}};
  if (out.smooth) return out;
  out.mean = energy::reflection_mean(roughness);
  out.later = later_bounces(reflectance.mean(), out.mean);
  out.spread = inv_pi / std::max(1 - out.mean, 1e-6F);
  return out;
}

Scattering scattering(const Lobe& lobe, const Vec3& wo, const Vec3& wi) {
  const Sides at = turned_up(lobe, wo, wi);
  if (!at.meet) return {};
  const ggx::Roughness roughness{lobe.alpha_x, lobe.alpha_y};
  const Once<float> once(roughness, at.wo, at.wi);
  Scattering out{.value = reflectance_of(lobe).at(once.cosine) * once.factor, .pdf = once.pdf};
  if (!(lobe.multiple_share > 0)) return out;
  const float lost = 1 - energy::reflection(at.wi, roughness);
  out.value += lobe.multiple * (lost * at.wi.z);
  out.pdf = pdf_of_all(lobe.multiple_share, once.pdf, at.wi.z);
  return out;
}

void Batch::add(const Lobe& lobe, const Vec3& wo, const Vec3& wi, Scattering& out) {
  const Sides at = turned_up(lobe, wo, wi);
  if (!at.meet) {
    out = {};
    return;
  }
  if (lobe.alpha_x != lobe.alpha_y) {
    out = scattering(lobe, wo, wi);
    return;
  }
  const Reflectance reflectance = reflectance_of(lobe);
  asked_.wo.set(count_, at.wo.x, at.wo.y, at.wo.z);
  asked_.wi.set(count_, at.wi.x, at.wi.y, at.wi.z);
  asked_.alpha[count_] = lobe.alpha_x;
  asked_.share[count_] = lobe.multiple_share;
  const auto set = [&](Three& to, const Color& color) {
    to.set(count_, color.r, color.g, color.b);
  };
  set(asked_.normal, reflectance.normal);
  set(asked_.rise, reflectance.rise);
  set(asked_.dip, reflectance.dip);
  set(asked_.multiple, lobe.multiple);
  found_[count_++] = &out;
  if (count_ == WideFloat::lanes) answer();
}

void Batch::answer() {
  if (count_ == 0) return;
  const auto all = [](const Row& row) { return WideFloat::load(row.data()); };
  const auto vector = [&](const Three& of) -> Vector3<WideFloat> {
    return {all(of[0]), all(of[1]), all(of[2])};
  };
  const Vector3<WideFloat> wo = vector(asked_.wo), wi = vector(asked_.wi);
  const WideFloat alpha = all(asked_.alpha), share = all(asked_.share);
  const Once<WideFloat> once({alpha, alpha}, wo, wi);
  const Reflectance::Parts<WideFloat> parts(once.cosine);
  const WideFloat later = (1.0F - energy::reflection(lesser(wi.z, WideFloat(1.0F)), alpha)) * wi.z;
  const auto some = share > 0.0F;
  const WideFloat pdf = select(some, pdf_of_all(share, once.pdf, wi.z), once.pdf);
  std::array<WideFloat, 3> value;
  for (std::size_t c = 0; c < value.size(); ++c) {
    const WideFloat first =
        parts.of(all(asked_.normal[c]), all(asked_.rise[c]), all(asked_.dip[c])) * once.factor;
    value[c] = select(some, first + all(asked_.multiple[c]) * later, first);
  }
  for (std::size_t lane = 0; lane < count_; ++lane)
    *found_[lane] = {.value = {value[0][lane], value[1][lane], value[2][lane]}, .pdf = pdf[lane]};
  count_ = 0;
}

Vec3 draw(const Lobe& lobe, const Vec3& wo, float u_part, Vec2 u) {
  if (wo.z == 0) return {};
  Vec3 wi;
  if (u_part < lobe.multiple_share) {
    wi = square_to_cosine_hemisphere(u);
  } else {
    const Vec3 up{wo.x, wo.y, std::abs(wo.z)};
    const Vec3 m = ggx::sample_visible_normal({lobe.alpha_x, lobe.alpha_y}, up, u);
    wi = normalize(m * (2 * dot(up, m)) - up);
    if (!(wi.z > 0)) return {};
  }
  const bool through = lobe.kind == LobeKind::microfacet_through;
  if ((wo.z < 0) != through) wi.z = -wi.z;
  return wi;
}

}  // namespace tessera::render::microfacet
