#include "worker/render/lights/light_table.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <utility>

namespace tessera::render {

LightTable::LightTable(std::vector<Light> lights, Choice choice) : lights_(std::move(lights)) {
  std::vector<double> powers;
  for (std::uint32_t i = 0; i < size(); ++i) {
    if (bounds(lights_[i]).empty()) {
      far_.push_back(i);
      if (!std::holds_alternative<DirectionalLight>(lights_[i].shape)) seen_far_.push_back(i);
    }
    if (choice == Choice::by_power)
      powers.push_back(static_cast<double>(luminance(power(lights_[i]))));
  }
  if (choice == Choice::by_power) {
    by_power_ = AliasTable(powers);
    return;
  }
  near_ = LightTree(lights_);
  weigh_far();
}

void LightTable::weigh_far() {
  std::vector<double> weights;
  double total = 0, shining = 0;
  for (const std::uint32_t light : far_) {
    weights.push_back(static_cast<double>(luminance(irradiance(lights_[light]))));
    total += weights.back();
    shining += weights.back() > 0 ? 1 : 0;
  }
  if (!(total > 0)) return;
  for (double& weight : weights) {
    if (weight > 0) weight = weight / total + 1 / shining;
  }
  far_choice_ = AliasTable(weights);
}

double LightTable::near_share(const LightContext& context) const {
  if (far_choice_.empty()) return 1;
  return near_.reaches(context) ? 0.5 : 0;
}

LightTable::Pick LightTable::pick(const LightContext& context, std::uint32_t bits) const {
  if (!by_power_.empty()) {
    const AliasTable::Pick chosen = by_power_.pick(bits);
    return {.light = chosen.index, .pmf = chosen.pmf};
  }
  const double u = bits * 0x1p-32, near = near_share(context);
  if (u < near) {
    const LightTree::Pick chosen = near_.pick(context, u / near);
    return {.light = chosen.light, .pmf = chosen.pmf * static_cast<float>(near)};
  }
  const double left = std::min((u - near) / (1 - near), 1 - 0x1p-32);
  const AliasTable::Pick chosen = far_choice_.pick(static_cast<std::uint32_t>(left * 0x1p32));
  return {.light = far_[chosen.index], .pmf = chosen.pmf * static_cast<float>(1 - near)};
}

float LightTable::pmf(const LightContext& context, std::uint32_t light) const {
  if (!by_power_.empty()) return by_power_.pmf(light);
  const double near = near_share(context);
  const auto far = std::lower_bound(far_.begin(), far_.end(), light);
  if (far == far_.end() || *far != light)
    return near > 0 ? near_.pmf(context, light) * static_cast<float>(near) : 0;
  const auto index = static_cast<std::uint32_t>(far - far_.begin());
  return far_choice_.empty() ? 0 : far_choice_.pmf(index) * static_cast<float>(1 - near);
}

LightSample LightTable::sample(const LightContext& context, std::uint32_t pick_bits, Vec2 u) const {
  const Pick chosen = pick(context, pick_bits);
  if (!(chosen.pmf > 0)) return {};
  LightSample drawn = render::sample(lights_[chosen.light], context, u);
  drawn.pdf *= chosen.pmf;
  drawn.light = chosen.light;
  return drawn;
}

void LightTable::sample(std::span<const LightRequest> asked, std::span<LightSample> found) const {
  assert(asked.size() <= found.size());
  constexpr std::size_t some = 16;
  std::array<Pick, some> picks;
  std::array<LightDraw, some> draws;
  while (!asked.empty()) {
    const std::size_t count = std::min(some, asked.size());
    for (std::size_t i = 0; i < count; ++i) {
      const LightRequest& request = asked[i];
      picks[i] = pick(*request.context, request.pick_bits);
      const Light* const light = picks[i].pmf > 0 ? &lights_[picks[i].light] : nullptr;
      draws[i] = {light, request.context, request.u};
    }
    render::sample({draws.data(), count}, found);
    for (std::size_t i = 0; i < count; ++i) {
      if (draws[i].light == nullptr) continue;
      found[i].pdf *= picks[i].pmf;
      found[i].light = picks[i].light;
    }
    asked = asked.subspan(count);
    found = found.subspan(count);
  }
}

float LightTable::pdf(const LightContext& context, std::uint32_t light, const LightHit& hit) const {
  const float choice = pmf(context, light);
  return choice > 0 ? choice * render::pdf(lights_[light], context, hit) : 0;
}

}  // namespace tessera::render
