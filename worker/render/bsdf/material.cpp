#include "worker/render/bsdf/material.hpp"

#include <algorithm>
#include <cassert>
#include <utility>
#include <variant>

#include "worker/render/fastmath.hpp"

namespace tessera::render {

namespace {

using Materials = std::span<const scene::Material>;

void append(CompiledMaterial& material, const Instruction& instruction) {
  assert(material.count < CompiledMaterial::instructions_max);
  material.program[static_cast<std::size_t>(material.count++)] = instruction;
}

void append(CompiledMaterial& material, const Surface& surface) {
  const std::uint8_t wants = std::visit([](const auto& one) { return one.wants(); }, surface);
  material.wants = static_cast<std::uint8_t>(material.wants | wants);
  material.surfaces.push_back(surface);
  append(material, Instruction{.code = Instruction::Code::surface,
                               .surface = static_cast<std::uint8_t>(material.surfaces.size() - 1)});
}

/// What is left of light after `distance` is `color`: −ln(color) / distance, at most so much that
/// nothing is left after it.
Color absorption(const scene::Color& color, double distance) {
  if (!(distance > 0)) return {};
  const auto of = [distance](double left) {
    return static_cast<float>(-fast::log(std::clamp(left, 1e-30, 1.0)) / distance);
  };
  return {of(color[0]), of(color[1]), of(color[2])};
}

void compile_diffuse(const scene::Material& source, Materials /*all*/, CompiledMaterial& out) {
  const auto& diffuse = std::get<scene::Diffuse>(source.surface);
  Lobe lobe{.kind = LobeKind::diffuse, .weight = to_color(diffuse.reflectance)};
  if (diffuse.roughness > 0) {
    lobe.kind = LobeKind::eon;
    lobe.tint = gray(1);
    lobe.alpha_x = static_cast<float>(diffuse.roughness);
  }
  append(out, {.lobe = lobe});
}

void compile_mirror(const scene::Material& source, Materials /*all*/, CompiledMaterial& out) {
  const auto& mirror = std::get<scene::Mirror>(source.surface);
  append(out, {.lobe = {.kind = LobeKind::mirror, .weight = to_color(mirror.reflectance)}});
}

void compile_dielectric(const scene::Material& source, Materials /*all*/, CompiledMaterial& out) {
  const auto& dielectric = std::get<scene::Dielectric>(source.surface);
  append(out, Surface(DielectricSurface(dielectric)));
  out.interface = !dielectric.thin_walled;
  out.medium = {static_cast<float>(dielectric.ior), source.priority,
                absorption(dielectric.attenuation_color, dielectric.attenuation_distance)};
}

void compile_emitter(const scene::Material& source, Materials /*all*/, CompiledMaterial& out) {
  const auto& emitter = std::get<scene::Emitter>(source.surface);
  out.radiance = to_color(emitter.radiance);
  out.two_sided = emitter.two_sided;
  append(out,
         {.code = emitter.two_sided ? Instruction::Code::emit_two_sided : Instruction::Code::emit,
          .radiance = out.radiance});
  const Color reflectance = to_color(emitter.reflectance);
  if (!is_black(reflectance))
    append(out, {.lobe = {.kind = LobeKind::diffuse, .weight = reflectance}});
}

void compile_conductor(const scene::Material& source, Materials /*all*/, CompiledMaterial& out) {
  append(out, Surface(ConductorSurface(std::get<scene::Conductor>(source.surface))));
}

void compile_principled(const scene::Material& source, Materials /*all*/, CompiledMaterial& out) {
  const auto& principled = std::get<scene::Principled>(source.surface);
  append(out, Surface(PrincipledSurface(principled, source.vertex_colors)));
  // What is unlit shines for the eye and is no light to sample: it is at most 1, and often all that
  // there is. Paths find it.
  if (!principled.unlit) {
    out.radiance = to_color(principled.emission.factor);
    if (principled.emission.texture) out.radiance_texture = compile(*principled.emission.texture);
    out.radiance_varies = principled.emission.texture || principled.clearcoat.factor > 0;
  }
  out.two_sided = true;
  out.interface = !principled.unlit && !principled.thin_walled &&
                  principled.transmission.factor > 0 && principled.metallic.factor < 1;
  out.medium = {static_cast<float>(principled.ior), source.priority,
                absorption(principled.attenuation_color, principled.attenuation_distance)};
}

void compile_mix(const scene::Material& source, Materials all, CompiledMaterial& out) {
  const auto& mix = std::get<scene::Mix>(source.surface);
  bool second = false;
  for (const std::uint32_t index : {mix.first, mix.second}) {
    assert(index < all.size() && !std::holds_alternative<scene::Mix>(all[index].surface));
    const CompiledMaterial part = compile(all[index]);
    assert(!part.emits());
    for (int i = 0; i < part.count; ++i) {
      const Instruction& step = part.program[static_cast<std::size_t>(i)];
      if (step.code == Instruction::Code::surface) {
        append(out, part.surfaces[step.surface]);
      } else {
        append(out, step);
      }
    }
    append(out, Surface(MixStep{ScalarSlot(mix.amount), second}));
    if (part.interface && !out.interface) {
      out.interface = true;
      out.medium = part.medium;
      out.medium.priority = source.priority;
    }
    second = true;
  }
}

struct Entry {
  std::string_view name;
  void (*compile)(const scene::Material&, Materials, CompiledMaterial&);
};
/// Every material there is, in the order of scene::Material::surface. The next one: its lobe's
/// file, a function above, a line here.
constexpr Entry materials[] = {
    {"diffuse", compile_diffuse},
    {"mirror", compile_mirror},
    {"dielectric", compile_dielectric},
    {"emitter", compile_emitter},
    {"conductor", compile_conductor},
    {"principled", compile_principled},
    {"mix", compile_mix},
};
static_assert(std::size(materials) == std::variant_size_v<decltype(scene::Material::surface)>);

/// Runs a surface. `part` is the closure's first lobe of the present part of a mix.
void run(const Surface& surface, const Source& source, int& part, Closure& out) {
  if (const auto* principled = std::get_if<PrincipledSurface>(&surface)) {
    principled->add(source, out);
  } else if (const auto* dielectric = std::get_if<DielectricSurface>(&surface)) {
    dielectric->add(source, out);
  } else if (const auto* conductor = std::get_if<ConductorSurface>(&surface)) {
    conductor->add(source, out);
  } else if (const auto* mix = std::get_if<MixStep>(&surface)) {
    const float amount = unit(mix->amount.at(source));
    scale(out, part, mix->second ? amount : 1 - amount);
    part = out.count;
  }
}

/// What holds for a material whatever its surface.
void compile_common(const scene::Material& source, CompiledMaterial& out) {
  unsigned wants = out.wants;
  out.back_culled = source.back_culled;
  const scene::Opacity& opacity = source.opacity;
  if (opacity.mode != scene::Opacity::Mode::opaque) {
    out.has_opacity = true;
    out.opacity = opacity.mode;
    out.cutoff = static_cast<float>(opacity.cutoff);
    out.alpha = ScalarSlot(opacity.alpha);
    out.vertex_alpha = source.vertex_colors;
    wants |= wanted_by(out.alpha);
    if (out.vertex_alpha) wants |= detail_flag::color;
    out.radiance_varies = true;
  }
  if (out.back_culled) out.two_sided = false;
  if (source.normal_map) {
    out.normal_map.emplace(*source.normal_map);
    wants = with_tangents_of(out.normal_map->texture, wants);
  }
  if (source.bump_map) {
    out.bump_map.emplace(*source.bump_map);
    wants |= wanted_by(out.bump_map->texture.uv_set);
    // Any will do: slopes are taken along whichever there are.
    if ((wants & detail_flag::tangent) == 0) wants |= tangents_by(out.bump_map->texture.uv_set);
  }
  out.bends_normals = out.normal_map || out.bump_map;
  out.may_pass = out.interface || out.has_opacity || out.back_culled;
  out.wants = static_cast<std::uint8_t>(wants);
}

}  // namespace

CompiledMaterial compile(const scene::Material& material, std::span<const scene::Material> all) {
  CompiledMaterial out;
  materials[material.surface.index()].compile(material, all, out);
  compile_common(material, out);
  return out;
}

Color emission(const CompiledMaterial& material, const TextureTable& textures,
               const ShadingPoint& point) {
  Color sum;
  for (int i = 0; i < material.count; ++i) {
    const Instruction& step = material.program[static_cast<std::size_t>(i)];
    const bool front = dot(point.wo, point.normal) > 0;
    if (step.code == Instruction::Code::emit_two_sided ||
        (step.code == Instruction::Code::emit && front)) {
      sum += step.radiance;
    } else if (step.code == Instruction::Code::surface) {
      const auto* const principled =
          std::get_if<PrincipledSurface>(&material.surfaces[step.surface]);
      if (principled != nullptr) sum += principled->emitted({point, textures});
    }
  }
  return sum * presence(material, textures, point);
}

float presence(const CompiledMaterial& material, const TextureTable& textures,
               const ShadingPoint& point) {
  if (material.back_culled && dot(point.wo, point.normal) < 0) return 0;
  if (!material.has_opacity) return 1;
  float alpha = material.alpha.at({point, textures});
  if (material.vertex_alpha && point.detail) alpha *= point.detail->alpha;
  if (material.opacity == scene::Opacity::Mode::mask) return alpha >= material.cutoff ? 1.0F : 0.0F;
  return unit(alpha);
}

std::vector<std::string_view> material_names() {
  std::vector<std::string_view> names;
  for (const Entry& entry : materials) names.push_back(entry.name);
  return names;
}

void evaluate(const CompiledMaterial& material, const TextureTable& textures,
              const ShadingPoint& point, Closure& out) {
  out.clear();
  out.shading = point.shading;
  if (material.bends_normals) [[unlikely]] {
    const Source source{point, textures};
    if (material.normal_map) out.shading = material.normal_map->frame(source);
    if (material.bump_map) out.shading = material.bump_map->frame(source, out.shading);
  }
  out.normal = point.normal;
  int part = 0;
  for (int i = 0; i < material.count; ++i) {
    const Instruction& step = material.program[static_cast<std::size_t>(i)];
    if (step.code == Instruction::Code::lobe) [[likely]] {
      out.add(step.lobe);
      continue;
    }
    switch (step.code) {
      case Instruction::Code::lobe:
        break;
      case Instruction::Code::emit:
        if (dot(point.wo, point.normal) > 0) out.emission += step.radiance;
        break;
      case Instruction::Code::emit_two_sided:
        out.emission += step.radiance;
        break;
      case Instruction::Code::surface:
        run(material.surfaces[step.surface], {point, textures}, part, out);
        break;
    }
  }
  if (!point.rounded) return;
  // Light samples look to one side alone, of one normal.
  out.rounded = (out.flags & lobe_flag::transmission) == 0 && out.frame_count == 0;
  out.round_normal = point.shading.n;
}

}  // namespace tessera::render
