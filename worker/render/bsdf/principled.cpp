#include "worker/render/bsdf/principled.hpp"

#include <algorithm>

#include "worker/render/bsdf/energy.hpp"
#include "worker/render/bsdf/layer.hpp"
#include "worker/render/bsdf/rough_dielectric.hpp"

namespace tessera::render {
namespace {

constexpr Reflectance coat_reflectance = schlick_reflectance(gray(0.04F), gray(1));

}  // namespace

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
  if (matte || unlit) return;
  energy::prepare_reflection(roughness_of(roughness.factor, anisotropy.factor));
  if (!thin_walled && source.transmission.factor > 0) energy::prepare_interface(ior);
  const ShadingPoint anywhere;
  const TextureTable none;
  if (!coat_roughness.texture) coat_everywhere_ = coat_surface_at({anywhere, none});
  if (is_textured()) return;
  everywhere_ = layers_at({anywhere, none});
  everywhere_->bounces = bounces_of(everywhere_->specular);
}

/// Some texture has a part in its layers.
bool PrincipledSurface::is_textured() const {
  return base_color.texture || specular_color.texture || metallic.texture || roughness.texture ||
         specular.texture || transmission.texture || anisotropy.texture || anisotropy_direction;
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
  microfacet::Surface surface;
  microfacet::View view;

  [[nodiscard]] float below() const { return unit(1 - albedo); }
};

microfacet::Surface PrincipledSurface::coat_surface_at(const Source& source) const {
  return microfacet::surface_of(coat_reflectance, roughness_of(unit(coat_roughness.at(source))));
}

PrincipledSurface::Coat PrincipledSurface::coat_at(const Source& source) const {
  Coat out;
  out.share = unit(coat.at(source));
  if (!(out.share > 0)) return out;
  out.frame = coat_normal ? coat_normal->frame(source) : source.point.shading;
  out.surface = coat_everywhere_ ? *coat_everywhere_ : coat_surface_at(source);
  out.view = microfacet::view_of(out.surface.roughness, {.cosine = facing(out.frame, source)});
  out.albedo = out.share * microfacet::albedo(out.surface, out.view).g;
  return out;
}

float PrincipledSurface::add_coat(const Coat& coat, Closure& out) {
  if (!(coat.share > 0)) return 1;
  Lobe lobe = scaled(microfacet::lobe_of(coat.surface, coat.view), gray(coat.share));
  if (!(coat.frame.n == out.shading.n)) lobe.frame = out.add_frame(coat.frame);
  out.add(lobe, coat.albedo);
  return coat.below();
}

bool PrincipledSurface::has_vertex_color(const Source& source) const {
  const auto& detail = source.point.detail;
  return vertex_colors && detail && (detail->has & detail_flag::color) != 0;
}

Color PrincipledSurface::tinted_base(const Source& source) const {
  Color base = base_color.at(source);
  if (has_vertex_color(source)) base *= source.point.detail->color;
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

PrincipledSurface::Layers PrincipledSurface::layers_at(const Source& source) const {
  const Color base = tinted_base(source);
  const float metal = unit(metallic.at(source)), through = unit(transmission.at(source));
  const float strength = unit(specular.at(source));
  const Brushing brushing = brushing_at(source);
  const ggx::Roughness rough = roughness_of(unit(roughness.at(source)), brushing.strength);
  const Color tint = specular_color.at(source);
  const Color normal = unit(tint * normal_reflectance(ior)) * strength;

  Layers out;
  out.direction = brushing.direction;
  // What has a volume behind it reflects by its interface's own lobe.
  out.interface = thin_walled ? 0 : through * (1 - metal);
  out.passing = thin_walled ? through : 0;
  if (out.passing > 0) out.passed = passing_of(rough);
  const float layered = (1 - metal) - out.interface;
  out.base = base * layered;
  out.interface_reflectance = unit(tint * strength) * out.interface;
  out.interface_transmittance = base * out.interface;

  out.dielectric = microfacet::surface_of(schlick_reflectance(normal, gray(strength)), rough);
  out.specular = out.dielectric;
  out.dielectric_alone = layered == 1;
  Reflectance& mixed = out.specular.reflectance;
  mixed = {mixed.normal * layered, mixed.rise * layered, {}};
  out.specular.later *= gray(layered);
  if (metal > 0) {
    const microfacet::Surface of_metal =
        microfacet::surface_of(schlick_reflectance(base, gray(1)), rough);
    mixed.normal += of_metal.reflectance.normal * metal;
    mixed.rise += of_metal.reflectance.rise * metal;
    out.specular.later += of_metal.later * metal;
  }
  return out;
}

void PrincipledSurface::add(const Source& source, Closure& out) const {
  if (unlit) {
    out.emission += tinted_base(source);
    return;
  }
  if (matte) {
    out.emission += emission.at(source);
    out.add({.kind = LobeKind::diffuse, .weight = tinted_base(source)});
    return;
  }
  const float below = coat.factor > 0 ? add_coat(coat_at(source), out) : 1;
  if (!is_black(emission.factor)) out.emission += emission.at(source) * below;
  if (everywhere_ && !has_vertex_color(source)) {
    add(*everywhere_, source, below, out);
  } else {
    add(layers_at(source), source, below, out);
  }
}

void PrincipledSurface::add(const Layers& layers, const Source& source, float below,
                            Closure& out) const {
  const ggx::Roughness& rough = layers.specular.roughness;
  const Layer layer = layers.bounces ? Layer(source, out.shading, *layers.bounces)
                                     : Layer(source, out.shading, rough, layers.direction);
  const Lobe lobe = microfacet::lobe_of(layers.specular, layer.view);
  const Color albedo = microfacet::albedo(layers.specular, layer.view);
  if (below == 1) {
    layer.add(lobe, albedo, out);
  } else {
    layer.add(scaled(lobe, gray(below)), albedo * below, out);
  }

  if (!is_black(layers.base)) {
    const Color reflected =
        layers.dielectric_alone ? albedo : microfacet::albedo(layers.dielectric, layer.view);
    const Color left = layers.base * (below * unit(1 - max_component(reflected)));
    out.add({.kind = LobeKind::diffuse, .weight = left * (1 - layers.passing)});
    if (layers.passing > 0)
      add_passing(facing(out.shading, source), left * layers.passing, layers.passed, out);
  }
  if (layers.interface > 0) {
    // From inside it reflects totally, whatever its strength.
    const float side = cosine_to(out.shading, source);
    const Color inside = gray(layers.interface);
    out.add(rough_dielectric::lobe_of(
        {.reflectance = (side > 0 ? layers.interface_reflectance : inside) * below,
         .transmittance = layers.interface_transmittance * below,
         .ior = ior / source.point.outside_ior,
         .roughness = {rough.alpha_y, rough.alpha_y},
         .cos_o = side}));
  }
}

}  // namespace tessera::render
