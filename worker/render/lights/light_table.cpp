#include "worker/render/lights/light_table.hpp"

#include <utility>

namespace tessera::render {

namespace {
constexpr double whole = 0x1p32;
}

LightTable::LightTable(std::vector<Light> lights)
    : lights_(std::move(lights)), buckets_(lights_.size()), pmf_(lights_.size(), 0.0F) {
  const std::size_t n = lights_.size();
  std::vector<double> share(n);
  double total = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (std::holds_alternative<EnvironmentLight>(lights_[i].shape)) {
      environment_ = static_cast<std::uint32_t>(i);
      continue;
    }
    share[i] = static_cast<double>(luminance(power(lights_[i])));
    total += share[i];
  }
  if (environment_ != no_id && luminance(lights_[environment_].radiance) > 0) {
    // As much as all others together, as pbrt-v4's BVHLightSampler does (lightsamplers.h). Its
    // power goes by how far the scene reaches, and a wide ground would leave nothing to the lamps.
    share[environment_] = total > 0 ? total : 1;
    total += share[environment_];
  }
  if (!(total > 0)) {
    buckets_.clear();
    return;
  }

  // Vose, "A linear algorithm for generating random numbers with a given distribution", 1991.
  std::vector<std::uint32_t> small, large;
  for (std::size_t i = 0; i < n; ++i) {
    share[i] *= static_cast<double>(n) / total;
    (share[i] < 1 ? small : large).push_back(static_cast<std::uint32_t>(i));
  }
  std::vector<double> own(n,
                          whole);  // of 2^32 numbers, those that stay with the bucket's own light
  for (std::size_t i = 0; i < n; ++i) buckets_[i].alias = static_cast<std::uint32_t>(i);
  while (!small.empty() && !large.empty()) {
    const std::uint32_t poor = small.back(), rich = large.back();
    small.pop_back();
    const auto threshold = static_cast<std::uint32_t>(share[poor] * (whole - 1));
    buckets_[poor] = {.threshold = threshold, .alias = rich};
    own[poor] = threshold;
    share[rich] -= 1 - share[poor];
    if (share[rich] < 1) {
      large.pop_back();
      small.push_back(rich);
    }
  }

  // What pick() truly does, thresholds rounded as they are.
  std::vector<double> numbers(n, 0.0);
  for (std::size_t i = 0; i < n; ++i) {
    numbers[i] += own[i];
    numbers[buckets_[i].alias] += whole - own[i];
  }
  for (std::size_t i = 0; i < n; ++i) {
    pmf_[i] = static_cast<float>(numbers[i] / (whole * static_cast<double>(n)));
  }
}

LightTable::Pick LightTable::pick(std::uint32_t bits) const {
  if (buckets_.empty()) return {};
  const std::uint64_t scaled = static_cast<std::uint64_t>(bits) * buckets_.size();
  const auto index = static_cast<std::uint32_t>(scaled >> 32);
  const Bucket& bucket = buckets_[index];
  const std::uint32_t light =
      static_cast<std::uint32_t>(scaled) < bucket.threshold ? index : bucket.alias;
  return {.light = light, .pmf = pmf_[light]};
}

LightSample LightTable::sample(const LightContext& context, std::uint32_t pick_bits, Vec2 u) const {
  const Pick chosen = pick(pick_bits);
  if (!(chosen.pmf > 0)) return {};
  LightSample drawn = render::sample(lights_[chosen.light], context, u);
  drawn.pdf *= chosen.pmf;
  drawn.light = chosen.light;
  return drawn;
}

float LightTable::pdf(const LightContext& context, std::uint32_t light, const LightHit& hit) const {
  const float choice = pmf_[light];
  return choice > 0 ? choice * render::pdf(lights_[light], context, hit) : 0;
}

}  // namespace tessera::render
