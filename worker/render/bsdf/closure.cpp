#include <algorithm>

#include "worker/render/bsdf/bsdf.hpp"
#include "worker/render/bsdf/lobe_calls.hpp"

namespace tessera::render {

Lobe scaled(const Lobe& lobe, const Color& by) {
  Lobe out = lobe;
  // An eon lobe is not linear in its albedo; later bounces in a rough dielectric are multiplied by
  // weight and tint anyhow.
  if (lobe.kind != LobeKind::eon) out.weight *= by;
  out.tint *= by;
  out.dip *= by;
  if (lobe.kind != LobeKind::rough_dielectric) out.multiple *= by;
  return out;
}

void scale(Closure& closure, int first, float by) {
  for (std::size_t i = index_of(first); i < index_of(closure.count); ++i) {
    closure.lobes[i] = scaled(closure.lobes[i], gray(by));
    closure.pick[i] *= by;
  }
  if (!(by > 0)) closure.count = std::min(closure.count, first);
  // Summed anew, so that what is left out leaves nothing behind.
  closure.pick_sum = 0;
  closure.flags = 0;
  closure.has_smooth = false;
  for (std::size_t i = 0; i < index_of(closure.count); ++i) {
    const std::uint8_t bits = lobe_flags(closure.lobes[i].kind);
    closure.pick_sum += closure.pick[i];
    closure.flags = static_cast<std::uint8_t>(closure.flags | bits);
    closure.has_smooth = closure.has_smooth || is_smooth(closure.lobes[i]);
  }
}

Color albedo(const Closure& closure) {
  Color sum;
  for (int i = 0; i < closure.count; ++i) {
    const Lobe& lobe = closure.lobes[index_of(i)];
    switch (lobe.kind) {
      case LobeKind::dielectric:
      case LobeKind::rough_dielectric:
      case LobeKind::pane:
        sum += gray(std::max(max_component(lobe.weight), max_component(lobe.tint)));
        break;
      case LobeKind::mirror:
        sum += is_black(lobe.tint) ? lobe.weight : lobe.tint;
        break;
      case LobeKind::eon:
        sum += lobe.weight * lobe.tint;
        break;
      case LobeKind::diffuse:
      case LobeKind::microfacet:
      case LobeKind::microfacet_through:
        sum += lobe.weight;
        break;
    }
  }
  return {std::clamp(sum.r, 0.0F, 1.0F), std::clamp(sum.g, 0.0F, 1.0F),
          std::clamp(sum.b, 0.0F, 1.0F)};
}

}  // namespace tessera::render
