#include "common/scene/gltf/rules.hpp"

#include <array>

#include "common/scene/fields.hpp"

namespace tessera::scene::gltf {

namespace {

constexpr double bytes_most = 1099511627776.0;
constexpr double count_most = 4294967295.0;
constexpr double int_most = 2147483647.0;  // TinyGLTF keeps no more of an extension's whole numbers

constexpr Field index(std::string_view key, std::string_view of) {
  return {.key = key, .is = Is::index, .of = of};
}
constexpr Field indices(std::string_view key, std::string_view of) {
  return {.key = key, .is = Is::indices, .of = of};
}
constexpr Field whole(std::string_view key, double low, double high) {
  return {.key = key, .is = Is::whole, .of = {}, .low = low, .high = high};
}
constexpr Field number(std::string_view key, double low, double high) {
  return {.key = key, .is = Is::number, .of = {}, .low = low, .high = high};
}
constexpr Field numbers(std::string_view key, std::uint32_t count, double low, double high) {
  return {.key = key, .is = Is::numbers, .of = {}, .low = low, .high = high, .count = count};
}
constexpr Field word(std::string_view key, std::string_view words) {
  return {.key = key, .is = Is::word, .of = words};
}
constexpr Field plain(std::string_view key, Is is) { return {.key = key, .is = is, .of = {}}; }
constexpr Field required(Field field) {
  field.required = true;
  return field;
}
constexpr Field name = plain("name", Is::text);

constexpr std::array root{required(plain("asset", Is::object)),
                          index("scene", "scenes"),
                          plain("extensionsUsed", Is::list),
                          plain("extensionsRequired", Is::list),
                          plain("scenes", Is::list),
                          plain("nodes", Is::list),
                          plain("meshes", Is::list),
                          plain("accessors", Is::list),
                          plain("bufferViews", Is::list),
                          plain("buffers", Is::list),
                          plain("images", Is::list),
                          plain("textures", Is::list),
                          plain("samplers", Is::list),
                          plain("materials", Is::list),
                          plain("cameras", Is::list),
                          plain("skins", Is::list),
                          plain("animations", Is::list)};
constexpr std::array asset{required(plain("version", Is::text)), plain("minVersion", Is::text)};
constexpr std::array scene{name, indices("nodes", "nodes")};
constexpr std::array node{name,
                          index("camera", "cameras"),
                          index("skin", "skins"),
                          index("mesh", "meshes"),
                          indices("children", "nodes"),
                          numbers("matrix", 16, -length_most, length_most),
                          numbers("rotation", 4, -1.001, 1.001),
                          numbers("scale", 3, -length_most, length_most),
                          numbers("translation", 3, -length_most, length_most),
                          numbers("weights", 0, -1e6, 1e6)};
constexpr std::array mesh{name, required(plain("primitives", Is::list)),
                          numbers("weights", 0, -1e6, 1e6)};
constexpr std::array primitive{required(plain("attributes", Is::object)),
                               index("indices", "accessors"), index("material", "materials"),
                               whole("mode", 0, 6), plain("targets", Is::list)};
constexpr std::array attributes{index("*", "accessors")};
constexpr std::array draco{required(index("bufferView", "bufferViews")),
                           required(plain("attributes", Is::object))};
constexpr std::array draco_attributes{whole("*", 0, int_most)};
constexpr std::array accessor{index("bufferView", "bufferViews"),
                              whole("byteOffset", 0, bytes_most),
                              required(word("componentType", "5120,5121,5122,5123,5125,5126,")),
                              plain("normalized", Is::flag),
                              required(whole("count", 1, count_most)),
                              required(word("type", "SCALAR,VEC2,VEC3,VEC4,MAT2,MAT3,MAT4,"))};
constexpr std::array sparse{required(whole("count", 1, int_most)),
                            required(plain("indices", Is::object)),
                            required(plain("values", Is::object))};
constexpr std::array sparse_indices{required(index("bufferView", "bufferViews")),
                                    whole("byteOffset", 0, int_most),
                                    required(word("componentType", "5121,5123,5125,"))};
constexpr std::array sparse_values{required(index("bufferView", "bufferViews")),
                                   whole("byteOffset", 0, int_most)};
constexpr std::array buffer_view{
    required(index("buffer", "buffers")), whole("byteOffset", 0, bytes_most),
    required(whole("byteLength", 1, bytes_most)), whole("byteStride", 4, 252)};
constexpr std::array buffer{plain("uri", Is::text), required(whole("byteLength", 1, bytes_most))};
constexpr std::array image{name, plain("uri", Is::text), plain("mimeType", Is::text),
                           index("bufferView", "bufferViews")};
constexpr std::array texture{name, index("sampler", "samplers"), index("source", "images")};
constexpr std::array sampler{
    word("magFilter", "9728,9729,"), word("minFilter", "9728,9729,9984,9985,9986,9987,"),
    word("wrapS", "33071,33648,10497,"), word("wrapT", "33071,33648,10497,")};
constexpr std::array material{name,
                              word("alphaMode", "OPAQUE,MASK,BLEND,"),
                              number("alphaCutoff", 0, radiance_most),
                              plain("doubleSided", Is::flag),
                              numbers("emissiveFactor", 3, 0, radiance_most),
                              plain("pbrMetallicRoughness", Is::object)};
constexpr std::array metallic_roughness{numbers("baseColorFactor", 4, 0, 1),
                                        number("metallicFactor", 0, 1),
                                        number("roughnessFactor", 0, 1)};
constexpr std::array normal_scale{number("scale", -1e6, 1e6)};
constexpr std::array camera{name, required(word("type", "perspective,orthographic,")),
                            plain("perspective", Is::object), plain("orthographic", Is::object)};
constexpr std::array perspective{
    required(number("yfov", 1e-5, 3.14159)), number("aspectRatio", 1e-3, 1e3),
    required(number("znear", 0, radiance_most)), number("zfar", 0, radiance_most)};
constexpr std::array orthographic{required(number("xmag", -length_most, length_most)),
                                  required(number("ymag", -length_most, length_most)),
                                  required(number("znear", 0, radiance_most)),
                                  required(number("zfar", 0, radiance_most))};
constexpr std::array skin{name, index("inverseBindMatrices", "accessors"),
                          index("skeleton", "nodes"), required(indices("joints", "nodes"))};
constexpr std::array animation{name, required(plain("channels", Is::list)),
                               required(plain("samplers", Is::list))};
constexpr std::array channel{required(whole("sampler", 0, int_most)),
                             required(plain("target", Is::object))};
constexpr std::array target{index("node", "nodes"), required(plain("path", Is::text))};
constexpr std::array animation_sampler{required(index("input", "accessors")),
                                       required(index("output", "accessors")),
                                       word("interpolation", "LINEAR,STEP,CUBICSPLINE,")};

constexpr std::array emissive_strength{number("emissiveStrength", 0, radiance_most)};
constexpr std::array ior{number("ior", 0, 100)};
constexpr std::array transmission{number("transmissionFactor", 0, 1)};
constexpr std::array volume{number("thicknessFactor", 0, length_most),
                            number("attenuationDistance", length_least, radiance_most),
                            numbers("attenuationColor", 3, 0, 1)};
constexpr std::array specular{number("specularFactor", 0, 1),
                              numbers("specularColorFactor", 3, 0, radiance_most)};
constexpr std::array clearcoat{number("clearcoatFactor", 0, 1),
                               number("clearcoatRoughnessFactor", 0, 1)};
constexpr std::array anisotropy{number("anisotropyStrength", 0, 1),
                                number("anisotropyRotation", -1e6, 1e6)};
constexpr std::array webp{index("source", "images")};
constexpr std::array node_light{required(index("light", "extensions/KHR_lights_punctual/lights"))};
constexpr std::array lights{required(plain("lights", Is::list))};
constexpr std::array light{name,
                           required(word("type", "directional,point,spot,")),
                           numbers("color", 3, 0, radiance_most),
                           number("intensity", 0, radiance_most),
                           number("range", 0, radiance_most),
                           plain("spot", Is::object)};
constexpr std::array spot{number("innerConeAngle", 0, 1.5707964),
                          number("outerConeAngle", 1e-6, 1.5707964)};
constexpr std::array variants{required(plain("variants", Is::list))};
constexpr std::array variant{required(name)};
constexpr std::array mapping{
    required(index("material", "materials")),
    required(indices("variants", "extensions/KHR_materials_variants/variants"))};
constexpr std::array instancing{required(plain("attributes", Is::object))};
constexpr std::array meshopt{required(index("buffer", "buffers")),
                             whole("byteOffset", 0, int_most),
                             required(whole("byteLength", 1, int_most)),
                             required(whole("byteStride", 1, 256)),
                             required(whole("count", 1, int_most)),
                             required(word("mode", "ATTRIBUTES,TRIANGLES,INDICES,")),
                             word("filter", "NONE,OCTAHEDRAL,QUATERNION,EXPONENTIAL,")};

constexpr std::array<Rule, 50> all_rules{{
    {"", root},
    {"asset", asset},
    {"scenes/*", scene},
    {"nodes/*", node},
    {"nodes/*/extensions/KHR_lights_punctual", node_light},
    {"nodes/*/extensions/EXT_mesh_gpu_instancing", instancing},
    {"nodes/*/extensions/EXT_mesh_gpu_instancing/attributes", attributes},
    {"meshes/*", mesh},
    {"meshes/*/primitives/*", primitive},
    {"meshes/*/primitives/*/attributes", attributes},
    {"meshes/*/primitives/*/targets/*", attributes},
    {"meshes/*/primitives/*/extensions/KHR_materials_variants/mappings/*", mapping},
    {"meshes/*/primitives/*/extensions/KHR_draco_mesh_compression", draco},
    {"meshes/*/primitives/*/extensions/KHR_draco_mesh_compression/attributes", draco_attributes},
    {"accessors/*", accessor},
    {"accessors/*/sparse", sparse},
    {"accessors/*/sparse/indices", sparse_indices},
    {"accessors/*/sparse/values", sparse_values},
    {"bufferViews/*", buffer_view},
    {"bufferViews/*/extensions/EXT_meshopt_compression", meshopt},
    {"buffers/*", buffer},
    {"images/*", image},
    {"textures/*", texture},
    {"textures/*/extensions/EXT_texture_webp", webp},
    {"samplers/*", sampler},
    {"materials/*", material},
    {"materials/*/pbrMetallicRoughness", metallic_roughness},
    {"materials/*/normalTexture", normal_scale},
    {"materials/*/extensions/KHR_materials_clearcoat/clearcoatNormalTexture", normal_scale},
    {"materials/*/extensions/KHR_materials_emissive_strength", emissive_strength},
    {"materials/*/extensions/KHR_materials_ior", ior},
    {"materials/*/extensions/KHR_materials_transmission", transmission},
    {"materials/*/extensions/KHR_materials_volume", volume},
    {"materials/*/extensions/KHR_materials_specular", specular},
    {"materials/*/extensions/KHR_materials_clearcoat", clearcoat},
    {"materials/*/extensions/KHR_materials_anisotropy", anisotropy},
    {"materials/*/extensions/KHR_materials_unlit", {}},
    {"cameras/*", camera},
    {"cameras/*/perspective", perspective},
    {"cameras/*/orthographic", orthographic},
    {"skins/*", skin},
    {"animations/*", animation},
    {"animations/*/channels/*", channel},
    {"animations/*/channels/*/target", target},
    {"animations/*/samplers/*", animation_sampler},
    {"extensions/KHR_lights_punctual", lights},
    {"extensions/KHR_lights_punctual/lights/*", light},
    {"extensions/KHR_lights_punctual/lights/*/spot", spot},
    {"extensions/KHR_materials_variants", variants},
    {"extensions/KHR_materials_variants/variants/*", variant},
}};

constexpr std::array<std::string_view, 13> all_texture_paths{
    "materials/*/pbrMetallicRoughness/baseColorTexture",
    "materials/*/pbrMetallicRoughness/metallicRoughnessTexture",
    "materials/*/normalTexture",
    "materials/*/occlusionTexture",
    "materials/*/emissiveTexture",
    "materials/*/extensions/KHR_materials_transmission/transmissionTexture",
    "materials/*/extensions/KHR_materials_volume/thicknessTexture",
    "materials/*/extensions/KHR_materials_specular/specularTexture",
    "materials/*/extensions/KHR_materials_specular/specularColorTexture",
    "materials/*/extensions/KHR_materials_clearcoat/clearcoatTexture",
    "materials/*/extensions/KHR_materials_clearcoat/clearcoatRoughnessTexture",
    "materials/*/extensions/KHR_materials_clearcoat/clearcoatNormalTexture",
    "materials/*/extensions/KHR_materials_anisotropy/anisotropyTexture"};
constexpr std::array texture_use{required(index("index", "textures")), whole("texCoord", 0, 255)};
constexpr std::array texture_transform{numbers("offset", 2, -1e9, 1e9),
                                       number("rotation", -1e6, 1e6),
                                       numbers("scale", 2, -1e9, 1e9), whole("texCoord", 0, 255)};

}  // namespace

std::span<const Rule> rules() { return all_rules; }
std::span<const std::string_view> texture_paths() { return all_texture_paths; }
std::span<const Field> texture_fields() { return texture_use; }
std::span<const Field> texture_transform_fields() { return texture_transform; }

}  // namespace tessera::scene::gltf
