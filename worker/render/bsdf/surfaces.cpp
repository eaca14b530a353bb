#include "worker/render/bsdf/surfaces.hpp"

#include <algorithm>
#include <cmath>

#include "worker/render/bsdf/energy.hpp"
#include "worker/render/bsdf/material.hpp"
#include "worker/render/bsdf/microfacet.hpp"
#include "worker/render/bsdf/pane.hpp"
#include "worker/render/bsdf/rough_dielectric.hpp"

namespace tessera::render {
namespace {

float cosine_to(const Frame& frame, const Source& source) { return dot(source.point.wo, frame.n); }
float facing(const Frame& frame, const Source& source) {
  return std::min(1.0F, std::abs(cosine_to(frame, source)));
}

/// KHR_materials_anisotropy: αt = mix(r², 1, strength²), αb = r².
ggx::Roughness roughness_of(float roughness, float strength = 0) {
  const float alpha = roughness * roughness;
  return {alpha + (1 - alpha) * strength * strength, alpha};
}

/// About the closure's normal, its first axis the surface's tangent, turned.
Frame turned_tangent(const Source& source, const Frame& shading, Vec2 direction) {
  const auto& detail = source.point.detail;
  const Frame axes = detail ? detail->tangents_about(shading.n) : shading;
  const Vec3 x = normalize(axes.s * direction.x + axes.t * direction.y);
  return Frame(x, cross(shading.n, x), shading.n);
}

/// A layer of microfacets at a hit, in a frame of its own where it is brushed.
struct Layer {
  ggx::Roughness roughness;
  Frame frame;
  energy::Slant wo;

  Layer(const Source& source, const Frame& shading, const ggx::Roughness& of, Vec2 direction)
      : roughness(of), frame(shading), wo{.cosine = facing(shading, source)} {
    if (roughness.alpha_x == roughness.alpha_y) return;
    frame = turned_tangent(source, shading, direction);
    wo = energy::slant_of(frame.to_local(source.point.wo));
  }
  [[nodiscard]] microfacet::Parameters with(const Reflectance& reflectance) const {
    return {.reflectance = reflectance, .roughness = roughness, .wo = wo};
  }
  void add(Lobe lobe, const Color& albedo, Closure& out) const {
    if (lobe.alpha_x != lobe.alpha_y) lobe.frame = out.add_frame(frame);
    out.add(lobe, max_component(albedo));
  }
};
Vec2 direction_of(float angle) {
  const auto [s, c] = fast::sincos(angle);
  return {c, s};
}

/// Light that goes straight through a thin wall, or nearly so.
void add_passing(float cosine, const Color& color, const ggx::Roughness& roughness, Closure& out) {
  if (std::max(roughness.alpha_x, roughness.alpha_y) < ggx::alpha_smooth) {
    out.add({.kind = LobeKind::pane, .tint = color, .ior = 1});
    return;
  }
  // Wide as it is across, whatever way the surface is brushed.
  const Lobe white = microfacet::lobe_of({.reflectance = {gray(1), {}, {}},
                                          .roughness = {roughness.alpha_y, roughness.alpha_y},
                                          .wo = {.cosine = cosine}},
                                         true);
  out.add(scaled(white, color), max_component(color));
}

}  // namespace

ConductorSurface::ConductorSurface(const scene::Conductor& source)
    : reflectance(conductor_reflectance(to_color(source.eta), to_color(source.k))),
      roughness(static_cast<float>(source.roughness)),
      anisotropy(static_cast<float>(source.anisotropy)),
      rotation(static_cast<float>(source.anisotropy_rotation)) {
  energy::prepare_reflection(roughness_of(roughness, anisotropy));
}

void ConductorSurface::add(const Source& source, Closure& out) const {
  const Layer layer(source, out.shading, roughness_of(roughness, anisotropy),
                    direction_of(rotation));
  const microfacet::Parameters parameters = layer.with(reflectance);
  layer.add(microfacet::lobe_of(parameters), microfacet::albedo(parameters), out);
}

DielectricSurface::DielectricSurface(const scene::Dielectric& source)
    : reflectance(to_color(source.reflectance)),
      transmittance(to_color(source.transmittance)),
      ior(static_cast<float>(source.ior)),
      roughness(static_cast<float>(source.roughness)),
      thin_walled(source.thin_walled) {
  if (roughness > 0) {
    if (thin_walled) energy::prepare_reflection();
    if (!thin_walled) energy::prepare_interface(ior);
  }
}

void DielectricSurface::add(const Source& source, Closure& out) const {
  const ggx::Roughness rough = roughness_of(roughness);
  if (!thin_walled) {
    out.add(rough_dielectric::lobe_of({.reflectance = reflectance,
                                       .transmittance = transmittance,
                                       .ior = ior / source.point.outside_ior,
                                       .roughness = rough,
                                       .cos_o = cosine_to(out.shading, source)}));
    return;
  }
  if (rough.alpha_x < ggx::alpha_smooth) {
    out.add({.kind = LobeKind::pane, .weight = reflectance, .tint = transmittance, .ior = ior});
    return;
  }
  const float face = pane::both_faces(normal_reflectance(ior));
  const Layer layer(source, out.shading, rough, {1, 0});
  const microfacet::Parameters faces = layer.with(schlick_reflectance(gray(face), gray(1)));
  const Color reflected = microfacet::albedo(faces);
  layer.add(scaled(microfacet::lobe_of(faces), reflectance), reflected * reflectance, out);
  add_passing(layer.wo.cosine, transmittance * unit(1 - reflected.g), rough, out);
}

PrincipledSurface::PrincipledSurface(const scene::Principled& source, bool uses_vertex_colors)
    : base_color(source.base_color),
      specular_color(source.specular_color),
      emission(source.emission),
      metallic(source.metallic),
      roughness(source.roughness),
      specular(source.specular),
      transmission(source.transmission),
      coat(source.clearcoat),
      coat_roughness(source.clearcoat_roughness),
      anisotropy(source.anisotropy),
      ior(static_cast<float>(source.ior)),
      rotation(static_cast<float>(source.anisotropy_rotation)),
      thin_walled(source.thin_walled),
      unlit(source.unlit),
      vertex_colors(uses_vertex_colors) {
  if (source.clearcoat_normal) coat_normal.emplace(*source.clearcoat_normal);
  if (source.anisotropy_direction) anisotropy_direction = compile(*source.anisotropy_direction);
  matte = !unlit && !(coat.factor > 0) && !(metallic.factor > 0) && !(transmission.factor > 0) &&
          !(specular.factor > 0);
  if (!matte) energy::prepare_reflection(roughness_of(roughness.factor, anisotropy.factor));
  if (!thin_walled && source.transmission.factor > 0) energy::prepare_interface(ior);
}

std::uint8_t PrincipledSurface::wants() const {
  unsigned bits = vertex_colors ? detail_flag::color : 0U;
  for (const ColorSlot* slot : {&base_color, &specular_color, &emission}) bits |= wanted_by(*slot);
  for (const ScalarSlot* slot :
       {&metallic, &roughness, &specular, &transmission, &coat, &coat_roughness, &anisotropy}) {
    bits |= wanted_by(*slot);
  }
  if (anisotropy_direction) bits |= wanted_by(anisotropy_direction->uv_set);
  if (anisotropy.factor > 0) {
    bits |= tangents_by(anisotropy_direction ? anisotropy_direction->uv_set : std::uint8_t{0});
  }
  if (coat_normal) bits = with_tangents_of(coat_normal->texture, bits);
  return static_cast<std::uint8_t>(bits);
}

/// The coat at a hit; nothing of it where `share` is 0.
struct PrincipledSurface::Coat {
  float share = 0;   ///< of the surface that is coated
  float albedo = 0;  ///< what it takes from all below
  Frame frame;
  microfacet::Parameters layer;

  [[nodiscard]] float below() const { return unit(1 - albedo); }
};

PrincipledSurface::Coat PrincipledSurface::coat_at(const Source& source) const {
  Coat out;
  out.share = unit(coat.at(source));
  if (!(out.share > 0)) return out;
  out.frame = coat_normal ? coat_normal->frame(source) : source.point.shading;
  out.layer = {.reflectance = schlick_reflectance(gray(0.04F), gray(1)),
               .roughness = roughness_of(unit(coat_roughness.at(source))),
               .wo = {.cosine = facing(out.frame, source)}};
  out.albedo = out.share * microfacet::albedo(out.layer).g;
  return out;
}

float PrincipledSurface::add_coat(const Coat& coat, Closure& out) {
  if (!(coat.share > 0)) return 1;
  Lobe lobe = scaled(microfacet::lobe_of(coat.layer), gray(coat.share));
  if (!(coat.frame.n == out.shading.n)) lobe.frame = out.add_frame(coat.frame);
  out.add(lobe, coat.albedo);
  return coat.below();
}

Color PrincipledSurface::tinted_base(const Source& source) const {
  Color base = base_color.at(source);
  if (vertex_colors && source.point.detail) base *= source.point.detail->color;
  return unit(base);
}

PrincipledSurface::Brushing PrincipledSurface::brushing_at(const Source& source) const {
  Brushing out;
  if (!(anisotropy.factor > 0)) return out;
  out.strength = anisotropy.at(source);
  out.direction = direction_of(rotation);
  if (anisotropy_direction) {
    const Texel texel = source.textures.lookup(*anisotropy_direction, source.point.detail);
    const Vec2 drawn{2 * texel[0] - 1, 2 * texel[1] - 1}, turn = out.direction;
    out.direction = {drawn.x * turn.x - drawn.y * turn.y, drawn.x * turn.y + drawn.y * turn.x};
    if (!(out.direction.x * out.direction.x + out.direction.y * out.direction.y > 0))
      out.direction = {1, 0};
    out.strength *= texel[2];
  }
  out.strength = unit(out.strength);
  return out;
}

Color PrincipledSurface::emitted(const Source& source) const {
  return unlit ? tinted_base(source) : emission.at(source) * coat_at(source).below();
}

void PrincipledSurface::add(const Source& source, Closure& out) const {
  const Color base = tinted_base(source);
  if (unlit) {
    out.emission += base;
    return;
  }
  if (matte) {
    out.emission += emission.at(source);
    out.add({.kind = LobeKind::diffuse, .weight = base});
    return;
  }
  const float below = add_coat(coat_at(source), out);
  out.emission += emission.at(source) * below;
  const float metal = unit(metallic.at(source)), passing = unit(transmission.at(source));
  const float strength = unit(specular.at(source));
  const Brushing brushing = brushing_at(source);
  const ggx::Roughness rough = roughness_of(unit(roughness.at(source)), brushing.strength);
  const Color tint = specular_color.at(source);
  const Color normal = unit(tint * normal_reflectance(ior)) * strength;
  const Reflectance dielectric = schlick_reflectance(normal, gray(strength));

  // What has a volume behind it reflects by its interface's own lobe.
  const float interface = thin_walled ? 0 : passing * (1 - metal) * below;
  const float layered = (1 - metal) * below - interface;
  const Layer layer(source, out.shading, rough, brushing.direction);
  Lobe specular_lobe;
  Color specular_albedo, reflected;
  if (layered > 0) {
    const microfacet::Parameters of_dielectric = layer.with(dielectric);
    reflected = microfacet::albedo(of_dielectric);
    specular_lobe = scaled(microfacet::lobe_of(of_dielectric), gray(layered));
    specular_albedo = reflected * layered;
  }
  if (metal > 0) {
    const microfacet::Parameters of_metal = layer.with(schlick_reflectance(base, gray(1)));
    const Lobe lobe = scaled(microfacet::lobe_of(of_metal), gray(metal * below));
    if (layered > 0) {
      specular_lobe.weight += lobe.weight;
      specular_lobe.tint += lobe.tint;
      specular_lobe.multiple += lobe.multiple;
    } else {
      specular_lobe = lobe;
    }
    specular_albedo += microfacet::albedo(of_metal) * (metal * below);
  }
  layer.add(specular_lobe, specular_albedo, out);
  const Color left = base * (layered * unit(1 - max_component(reflected)));
  const float through = thin_walled ? passing : 0;
  out.add({.kind = LobeKind::diffuse, .weight = left * (1 - through)});
  if (through > 0) add_passing(facing(out.shading, source), left * through, rough, out);
  if (interface > 0) {
    // From inside it reflects totally, whatever its strength.
    const float side = cosine_to(out.shading, source);
    out.add(rough_dielectric::lobe_of(
        {.reflectance = (side > 0 ? unit(tint * strength) : gray(1)) * interface,
         .transmittance = base * interface,
         .ior = ior / source.point.outside_ior,
         .roughness = {rough.alpha_y, rough.alpha_y},
         .cos_o = side}));
  }
}

}  // namespace tessera::render
