#include <fmt/format.h>

#include <array>

#include "common/base/names.hpp"
#include "common/scene/parts.hpp"

namespace tessera::scene {

namespace {

using Surface = decltype(Material::surface);

Surface diffuse(Fields& in) {
  Diffuse out;
  out.reflectance = in.color_or("reflectance", 1, out.reflectance);
  return out;
}
Surface mirror(Fields& in) {
  Mirror out;
  out.reflectance = in.color_or("reflectance", 1, out.reflectance);
  return out;
}
Surface dielectric(Fields& in) {
  Dielectric out;
  out.ior = in.number_or("ior", 0.01, 100, out.ior);
  out.transmittance = in.color_or("transmittance", 1, out.transmittance);
  out.reflectance = in.color_or("reflectance", 1, out.reflectance);
  return out;
}
Surface emitter(Fields& in) {
  Emitter out;
  out.radiance = in.required("radiance").color(radiance_most);
  out.two_sided = in.boolean_or("two_sided", out.two_sided);
  out.reflectance = in.color_or("reflectance", 1, out.reflectance);
  return out;
}

struct MaterialType {
  std::string_view name;
  Surface (*read)(Fields&);
};
/// Every type of material that a scene can name.
constexpr std::array<MaterialType, 4> material_types{
    {{"diffuse", diffuse}, {"mirror", mirror}, {"dielectric", dielectric}, {"emitter", emitter}}};

}  // namespace

std::vector<Material> read_materials(const Value& materials) {
  std::vector<std::string_view> types;
  for (const MaterialType& type : material_types) types.push_back(type.name);
  std::vector<Material> out;
  for (const Value::Member& member : materials.members()) {
    if (out.size() == materials_most)
      member.key.fail(fmt::format("the scene has more than {} materials", materials_most));
    const std::string& name = member.key.text();
    if (!is_plain_name(name))
      member.key.fail("expected a name of 1 to 128 bytes without control characters");
    Fields fields(member.value);
    const std::string type = read_name(fields, "type", "material type", types);
    for (const MaterialType& known : material_types)
      if (type == known.name) out.push_back({name, known.read(fields)});
    fields.finish();
  }
  return out;
}

}  // namespace tessera::scene
