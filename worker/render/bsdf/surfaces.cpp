#include "worker/render/bsdf/surfaces.hpp"

#include <algorithm>

#include "worker/render/bsdf/energy.hpp"
#include "worker/render/bsdf/layer.hpp"
#include "worker/render/bsdf/pane.hpp"
#include "worker/render/bsdf/rough_dielectric.hpp"

namespace tessera::render {

ConductorSurface::ConductorSurface(const scene::Conductor& source)
    : surface(
          microfacet::surface_of(conductor_reflectance(to_color(source.eta), to_color(source.k)),
                                 roughness_of(static_cast<float>(source.roughness),
                                              static_cast<float>(source.anisotropy)))),
      direction(direction_of(static_cast<float>(source.anisotropy_rotation))),
      bounces(bounces_of(surface)) {}

void ConductorSurface::add(const Source& source, Closure& out) const {
  const Layer layer = bounces ? Layer(source, out.shading, *bounces)
                              : Layer(source, out.shading, surface.roughness, direction);
  layer.add(microfacet::lobe_of(surface, layer.view), microfacet::albedo(surface, layer.view), out);
}

DielectricSurface::DielectricSurface(const scene::Dielectric& source)
    : reflectance(to_color(source.reflectance)),
      transmittance(to_color(source.transmittance)),
      ior(static_cast<float>(source.ior)),
      roughness(roughness_of(static_cast<float>(source.roughness))),
      thin_walled(source.thin_walled) {
  if (source.roughness > 0 && !thin_walled) energy::prepare_interface(ior);
  if (!thin_walled) return;
  const float face = pane::both_faces(normal_reflectance(ior));
  faces = microfacet::surface_of(schlick_reflectance(gray(face), gray(1)), roughness);
  passing = passing_of(roughness);
}

void DielectricSurface::add(const Source& source, Closure& out) const {
  if (!thin_walled) {
    out.add(rough_dielectric::lobe_of({.reflectance = reflectance,
                                       .transmittance = transmittance,
                                       .ior = ior / source.point.outside_ior,
                                       .roughness = roughness,
                                       .cos_o = cosine_to(out.shading, source)}));
    return;
  }
  if (faces.smooth) {
    out.add({.kind = LobeKind::pane, .weight = reflectance, .tint = transmittance, .ior = ior});
    return;
  }
  const Layer layer(source, out.shading, roughness, {1, 0});
  const Color reflected = microfacet::albedo(faces, layer.view);
  layer.add(scaled(microfacet::lobe_of(faces, layer.view), reflectance), reflected * reflectance,
            out);
  add_passing(layer.view.cosine, transmittance * unit(1 - reflected.g), passing, out);
}

}  // namespace tessera::render
