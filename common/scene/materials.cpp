#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <unordered_map>
#include <utility>

#include "common/base/limits.hpp"
#include "common/base/names.hpp"
#include "common/scene/metals.hpp"
#include "common/scene/parts.hpp"

namespace tessera::scene {

namespace {

using Surface = decltype(Material::surface);

constexpr double degrees = 3.14159265358979323846 / 180;
constexpr double index_most = 100;

Surface diffuse(Fields& in, Reading& /*reading*/) {
  Diffuse out;
  out.reflectance = in.color_or("reflectance", 1, out.reflectance);
  out.roughness = in.number_or("roughness", 0, 1, out.roughness);
  return out;
}
Surface mirror(Fields& in, Reading& /*reading*/) {
  Mirror out;
  out.reflectance = in.color_or("reflectance", 1, out.reflectance);
  return out;
}

/// What the inside of a closed shape absorbs.
template <class Inside>
void read_attenuation(Fields& in, Inside& out) {
  out.attenuation_color = in.color_or("attenuation_color", 1, out.attenuation_color);
  const auto distance = in.optional("attenuation_distance");
  if (distance) out.attenuation_distance = distance->number(length_least, length_most);
  if (distance.has_value() != in.has("attenuation_color")) {
    in.self().fail(
        "give attenuation_color and attenuation_distance together: what is left of light after "
        "that distance");
  }
  if (distance && out.thin_walled)
    distance->fail("what is thin-walled has no inside: give \"thin_walled\": false too");
}

Surface dielectric(Fields& in, Reading& /*reading*/) {
  Dielectric out;
  out.ior = in.number_or("ior", 0.01, index_most, out.ior);
  out.transmittance = in.color_or("transmittance", 1, out.transmittance);
  out.reflectance = in.color_or("reflectance", 1, out.reflectance);
  out.roughness = in.number_or("roughness", 0, 1, out.roughness);
  out.thin_walled = in.boolean_or("thin_walled", out.thin_walled);
  read_attenuation(in, out);
  return out;
}
Surface emitter(Fields& in, Reading& /*reading*/) {
  Emitter out;
  out.radiance = in.required("radiance").color(radiance_most);
  out.two_sided = in.boolean_or("two_sided", out.two_sided);
  out.reflectance = in.color_or("reflectance", 1, out.reflectance);
  return out;
}

Surface conductor(Fields& in, Reading& /*reading*/) {
  Conductor out;
  const auto name = in.optional("name");
  if (name && (in.has("eta") || in.has("k")))
    name->fail("give a metal's name, or eta and k, and not both");
  if (name) {
    std::vector<std::string_view> names;
    for (const Metal& metal : metals) names.push_back(metal.name);
    const std::string& text = name->text();
    const auto* const found = std::find_if(metals.begin(), metals.end(),
                                           [&](const Metal& metal) { return metal.name == text; });
    if (found == metals.end()) name->fail(unknown_name("metal", text, names));
    out.eta = found->eta;
    out.k = found->k;
  } else {
    out.eta = in.required("eta").color(index_most);
    out.k = in.required("k").color(index_most);
  }
  out.roughness = in.number_or("roughness", 0, 1, out.roughness);
  out.anisotropy = in.number_or("anisotropy", 0, 1, out.anisotropy);
  out.anisotropy_rotation = in.number_or("anisotropy_rotation", -360, 360, 0) * degrees;
  return out;
}

Surface principled(Fields& in, Reading& reading) {
  Principled out;
  const auto unit = [&](std::string_view key, ScalarInput& input) {
    input = scalar_input_or(in, key, 0, 1, input, reading);
  };
  const auto color = [&](std::string_view key, double most, ColorInput& input) {
    input = color_input_or(in, key, most, input, reading);
  };
  color("base_color", 1, out.base_color);
  unit("metallic", out.metallic);
  unit("roughness", out.roughness);
  out.ior = in.number_or("ior", 1, index_most, out.ior);
  unit("specular", out.specular);
  color("specular_color", index_most, out.specular_color);
  unit("transmission", out.transmission);
  out.thin_walled = in.boolean_or("thin_walled", out.thin_walled);
  read_attenuation(in, out);
  unit("clearcoat", out.clearcoat);
  unit("clearcoat_roughness", out.clearcoat_roughness);
  unit("anisotropy", out.anisotropy);
  out.anisotropy_rotation = in.number_or("anisotropy_rotation", -360, 360, 0) * degrees;
  if (const auto map = in.optional("clearcoat_normal_map"))
    out.clearcoat_normal = read_normal_map(*map, reading);
  color("emission", radiance_most, out.emission);
  out.unlit = in.boolean_or("unlit", out.unlit);
  return out;
}

/// Its two materials are looked up when all have been read.
Surface mix(Fields& in, Reading& reading) {
  Mix out;
  (void)in.required("materials");
  out.amount = scalar_input_or(in, "amount", 0, 1, out.amount, reading);
  return out;
}

struct MaterialType {
  std::string_view name;
  Surface (*read)(Fields&, Reading&);
};
/// Every type of material that a scene can name.
constexpr std::array<MaterialType, 7> material_types{{{"diffuse", diffuse},
                                                      {"mirror", mirror},
                                                      {"dielectric", dielectric},
                                                      {"emitter", emitter},
                                                      {"conductor", conductor},
                                                      {"principled", principled},
                                                      {"mix", mix}}};

/// What any material may say.
void read_common(Fields& in, Material& out, Reading& reading) {
  if (in.has("opacity")) {
    out.opacity.mode = Opacity::Mode::blend;
    out.opacity.alpha = scalar_input_or(in, "opacity", 0, 1, out.opacity.alpha, reading);
  }
  if (const auto cutoff = in.optional("alpha_cutoff")) {
    if (!in.has("opacity"))
      cutoff->fail("give opacity too: the surface is there where that is at least this");
    out.opacity.mode = Opacity::Mode::mask;
    out.opacity.cutoff = cutoff->number(0, 1);
  }
  if (const auto map = in.optional("normal_map")) out.normal_map = read_normal_map(*map, reading);
  if (const auto map = in.optional("bump_map")) out.bump_map = read_bump_map(*map, reading);
  out.back_culled = in.boolean_or("back_culled", out.back_culled);
  out.priority = static_cast<std::int32_t>(in.integer_or("priority", -1000, 1000, out.priority));
  out.light_group = read_light_group(in);
  if (in.has("group") && !is_light(out))
    in.required("group").fail("only what emits is in a light group, and this material does not");
}

bool is_unlit(const Material& material) {
  const auto* const principled = std::get_if<Principled>(&material.surface);
  return principled != nullptr && principled->unlit;
}

/// True if light passes it into an inside, whose other end it must find.
bool has_inside(const Material& material) {
  if (const auto* glass = std::get_if<Dielectric>(&material.surface)) return !glass->thin_walled;
  const auto* const principled = std::get_if<Principled>(&material.surface);
  return principled != nullptr && !principled->thin_walled && principled->transmission.factor != 0;
}

void check_culling(Fields& in, const Material& material, const Material& part) {
  if (material.back_culled && has_inside(part))
    in.required("back_culled").fail("what light passes into has a back from which it leaves");
}

using MaterialIndex = std::unordered_map<std::string, std::uint32_t>;

/// One of the two that a mix names.
std::uint32_t part_of_mix(const Value& value, const std::vector<Material>& all,
                          const MaterialIndex& index) {
  const std::string& name = value.text();
  const auto found = index.find(name);
  if (found == index.end()) {
    std::vector<std::string_view> names;
    for (const Material& material : all) names.push_back(material.name);
    value.fail(unknown_name("material", name, names));
  }
  const Material& part = all[found->second];
  if (std::holds_alternative<Mix>(part.surface)) value.fail("a mix cannot be part of a mix");
  if (is_light(part)) value.fail("what emits cannot be part of a mix");
  if (is_unlit(part)) value.fail("what is unlit cannot be part of a mix");
  if (part.opacity.mode != Opacity::Mode::opaque || part.back_culled || part.priority != 0 ||
      part.normal_map || part.bump_map)
    value.fail(
        "opacity, back_culled, priority, normal_map and bump_map belong to the mix, not to its "
        "parts");
  return found->second;
}

}  // namespace

bool is_light(const Material& material) {
  if (std::holds_alternative<Emitter>(material.surface)) return true;
  const auto* const principled = std::get_if<Principled>(&material.surface);
  return principled != nullptr && principled->emission.factor != Color{0, 0, 0};
}

std::vector<Material> read_materials(const Value& materials, Reading& reading) {
  std::vector<std::string_view> types;
  for (const MaterialType& type : material_types) types.push_back(type.name);
  std::vector<Material> out;
  MaterialIndex index;
  std::vector<std::pair<std::size_t, Value>> mixes;
  for (const Value::Member& member : materials.members()) {
    if (out.size() == limits::materials_max)
      member.key.fail(fmt::format("the scene has more than {} materials", limits::materials_max));
    const std::string& name = plain_name(member.key);
    Fields fields(member.value);
    const std::string type = read_name(fields, "type", "material type", types);
    index.emplace(name, static_cast<std::uint32_t>(out.size()));
    for (const MaterialType& known : material_types)
      if (type == known.name) out.push_back({name, known.read(fields, reading)});
    read_common(fields, out.back(), reading);
    check_culling(fields, out.back(), out.back());
    if (type == "mix") mixes.emplace_back(out.size() - 1, member.value);
    fields.finish();
  }
  for (const auto& [at, value] : mixes) {
    Fields fields(value);
    const Value list = fields.required("materials");
    const std::vector<Value> parts = list.items("a list of two materials");
    if (parts.size() != 2) list.fail_expected("a list of two materials");
    auto& mixed = std::get<Mix>(out[at].surface);
    mixed.first = part_of_mix(parts[0], out, index);
    mixed.second = part_of_mix(parts[1], out, index);
    for (const std::uint32_t part : {mixed.first, mixed.second})
      check_culling(fields, out[at], out[part]);
  }
  return out;
}

}  // namespace tessera::scene
