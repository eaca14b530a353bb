#include "worker/render/bsdf/layer.hpp"

#include "worker/render/fastmath.hpp"

namespace tessera::render {
namespace {

/// About the closure's normal, its first axis the surface's tangent, turned.
Frame turned_tangent(const Source& source, const Frame& shading, Vec2 direction) {
  const auto& detail = source.point.detail;
  const Frame axes = detail ? detail->tangents_about(shading.n) : shading;
  const Vec3 x = normalize(axes.s * direction.x + axes.t * direction.y);
  return Frame(x, cross(shading.n, x), shading.n);
}

}  // namespace

Vec2 direction_of(float angle) {
  const auto [s, c] = fast::sincos(angle);
  return {c, s};
}

Layer::Layer(const Source& source, const Frame& shading, const ggx::Roughness& roughness,
             Vec2 direction) {
  if (roughness.alpha_x == roughness.alpha_y) {
    view = microfacet::view_of(roughness, {.cosine = facing(shading, source)});
    return;
  }
  brushed = turned_tangent(source, shading, direction);
  view = microfacet::view_of(roughness, energy::slant_of(brushed->to_local(source.point.wo)));
}

void Layer::add_brushed(const Lobe& lobe, float weight, Closure& out) const {
  if (!(weight > 0)) return;
  Lobe turned = lobe;
  turned.frame = out.add_frame(*brushed);
  out.add(turned, weight);
}

microfacet::Surface passing_of(const ggx::Roughness& roughness) {
  return microfacet::surface_of({gray(1), {}, {}}, {roughness.alpha_y, roughness.alpha_y});
}

void add_passing(float cosine, const Color& color, const microfacet::Surface& passing,
                 Closure& out) {
  if (passing.smooth) {
    out.add({.kind = LobeKind::pane, .tint = color, .ior = 1});
    return;
  }
  const microfacet::View view = microfacet::view_of(passing.roughness, {.cosine = cosine});
  out.add(scaled(microfacet::lobe_of(passing, view, true), color), max_component(color));
}

}  // namespace tessera::render
