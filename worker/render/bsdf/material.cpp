#include "worker/render/bsdf/material.hpp"

#include <cassert>
#include <variant>

namespace tessera::render {

namespace {

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
