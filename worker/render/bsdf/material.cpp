#include "worker/render/bsdf/material.hpp"

#include <cassert>
#include <variant>

namespace tessera::render {

namespace {

/// ((η − 1)² + k²) / ((η + 1)² + k²), the reflectance of a conductor seen along its normal.
Color normal_reflectance(const Color& eta, const Color& k) {
  const auto of = [](float n, float extinction) {
    const float k2 = extinction * extinction;
    return ((n - 1) * (n - 1) + k2) / ((n + 1) * (n + 1) + k2);
  };
  return {of(eta.r, k.r), of(eta.g, k.g), of(eta.b, k.b)};
}

void append(CompiledMaterial& material, const Instruction& instruction) {
  assert(material.count < CompiledMaterial::instructions_max);
  material.program[static_cast<std::size_t>(material.count++)] = instruction;
}

void compile_diffuse(const scene::Material& source, CompiledMaterial& out) {
  const auto& diffuse = std::get<scene::Diffuse>(source.surface);
  append(out, {.lobe = {.kind = LobeKind::diffuse, .weight = to_color(diffuse.reflectance)}});
}

void compile_mirror(const scene::Material& source, CompiledMaterial& out) {
  const auto& mirror = std::get<scene::Mirror>(source.surface);
  append(out, {.lobe = {.kind = LobeKind::mirror, .weight = to_color(mirror.reflectance)}});
}

void compile_dielectric(const scene::Material& source, CompiledMaterial& out) {
  const auto& dielectric = std::get<scene::Dielectric>(source.surface);
  append(out, {.lobe = {.kind = LobeKind::dielectric,
                        .weight = to_color(dielectric.reflectance),
                        .tint = to_color(dielectric.transmittance),
                        .ior = static_cast<float>(dielectric.ior)}});
}

void compile_emitter(const scene::Material& source, CompiledMaterial& out) {
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

void compile_conductor(const scene::Material& source, CompiledMaterial& out) {
  const auto& conductor = std::get<scene::Conductor>(source.surface);
  append(out,
         {.lobe = {.kind = LobeKind::mirror,
                   .weight = normal_reflectance(to_color(conductor.eta), to_color(conductor.k))}});
}

/// What is diffuse of it, and what it emits.
void compile_principled(const scene::Material& source, CompiledMaterial& out) {
  const auto& principled = std::get<scene::Principled>(source.surface);
  const Color base = to_color(principled.base_color.factor);
  const Color emission = principled.unlit ? base : to_color(principled.emission.factor);
  if (!is_black(emission)) {
    if (!principled.unlit) out.radiance = emission;
    out.two_sided = true;
    append(out, {.code = Instruction::Code::emit_two_sided, .radiance = emission});
  }
  if (!principled.unlit) append(out, {.lobe = {.kind = LobeKind::diffuse, .weight = base}});
}

/// A mix has no steps of its own: compile_all() joins those of its two.
void compile_mix(const scene::Material& /*source*/, CompiledMaterial& /*out*/) {}

struct Entry {
  std::string_view name;
  void (*compile)(const scene::Material&, CompiledMaterial&);
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

}  // namespace

CompiledMaterial compile(const scene::Material& material) {
  CompiledMaterial out;
  materials[material.surface.index()].compile(material, out);
  return out;
}

std::vector<std::string_view> material_names() {
  std::vector<std::string_view> names;
  for (const Entry& entry : materials) names.push_back(entry.name);
  return names;
}

void evaluate(const CompiledMaterial& material, const ShadingPoint& point, Closure& out) {
  out.clear();
  out.shading = point.shading;
  out.normal = point.normal;
  for (int i = 0; i < material.count; ++i) {
    const Instruction& step = material.program[static_cast<std::size_t>(i)];
    switch (step.code) {
      case Instruction::Code::lobe:
        out.add(step.lobe);
        break;
      case Instruction::Code::emit:
        if (dot(point.wo, point.normal) > 0) out.emission += step.radiance;
        break;
      case Instruction::Code::emit_two_sided:
        out.emission += step.radiance;
        break;
    }
  }
}

}  // namespace tessera::render
