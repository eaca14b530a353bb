#include "client/scene_facts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/scene/image_bytes.hpp"
#include "common/scene/outline.hpp"
#include "common/scene/shadow_catchers.hpp"
#include "common/scene/texture_uses.hpp"

namespace tessera::client {

namespace {

using scene::Box;
using scene::Disk;
using scene::Mesh;
using scene::Quad;
using scene::Sphere;

// Of Embree's hierarchies, by its memory monitor, on displaced spheres of .2 to 2.9 million
// triangles: 68 bytes of each stay, 103 to 114 are held while it is built.
constexpr std::uint64_t hierarchy_bytes_of_triangle = 114, instance_bytes = 382;
constexpr std::uint64_t face_bytes = 3 * 4 + 2;  ///< a triangle's indices, and its material

std::uint64_t triangles_of(const Mesh& mesh) { return size_of(mesh).triangles; }
std::uint64_t triangles_of(const Quad&) { return 2; }
std::uint64_t triangles_of(const Disk&) { return 2; }  // the square around it
std::uint64_t triangles_of(const Box&) { return 12; }
std::uint64_t triangles_of(const Sphere&) { return 0; }

/// Which texture coordinates a worker keeps of a shape, where it has them: those that its material
/// looks at, and set 0 for jobs that ask for the AOV `UV`.
struct Coordinates {
  bool first = false, second = false;
};
constexpr std::uint64_t coordinates_bytes = 8;  ///< of a vertex

/// As the renderer keeps it: a normal takes 4 bytes.
std::uint64_t bytes_of(const Mesh& mesh, const Coordinates& kept) {
  const scene::MeshSize size = size_of(mesh);
  // The first set stands in for the second where there is none.
  const bool first = kept.first || (kept.second && size.uvs1 == 0);
  const std::uint64_t uvs = (first ? size.uvs : 0) + (kept.second ? size.uvs1 : 0);
  return size.positions * 12 + size.normals * 4 + uvs * coordinates_bytes + size.tangents * 4 +
         size.colors * 8 + size.triangles * face_bytes;
}
std::uint64_t bytes_of(const Quad&, const Coordinates& kept) {
  return 4 * 12 + 16 + 2 + (kept.first || kept.second ? 4 * coordinates_bytes : 0);
}
std::uint64_t bytes_of(const Disk&, const Coordinates& kept) { return bytes_of(Quad{}, kept); }
std::uint64_t bytes_of(const Box&, const Coordinates& kept) { return 6 * bytes_of(Quad{}, kept); }
std::uint64_t bytes_of(const Sphere&, const Coordinates&) { return 16 + 2; }

std::uint64_t triangles_of(const std::vector<scene::Shape>& shapes) {
  std::uint64_t out = 0;
  for (const scene::Shape& shape : shapes)
    out += std::visit([](const auto& one) { return triangles_of(one); }, shape.geometry);
  return out;
}

/// By the scene's materials.
std::vector<Coordinates> coordinates_kept(const scene::Scene& from) {
  const auto& aovs = from.render.aovs;
  const bool for_aov = std::find(aovs.begin(), aovs.end(), "UV") != aovs.end();
  std::vector<Coordinates> out;
  for (const scene::Material& material : from.materials) {
    const auto [first, second] = coordinate_sets(material, from.materials);
    out.push_back({first || for_aov, second});
  }
  return out;
}

void count(const std::vector<scene::Shape>& shapes, const std::vector<Coordinates>& kept,
           SceneFacts& out) {
  out.triangles += triangles_of(shapes);
  out.shapes += shapes.size();
  for (const scene::Shape& shape : shapes) {
    out.geometry_bytes += std::visit(
        [&](const auto& one) { return bytes_of(one, kept[shape.material]); }, shape.geometry);
    if (std::holds_alternative<Sphere>(shape.geometry)) ++out.spheres;
  }
}

bool emits(const scene::Material& material) {
  if (std::holds_alternative<scene::Emitter>(material.surface)) return true;
  const auto* surface = std::get_if<scene::Principled>(&material.surface);
  return surface != nullptr &&
         (surface->unlit || surface->emission.factor != scene::Color{0, 0, 0});
}

std::string size_text(std::uint64_t bytes) {
  constexpr double step = 1024;
  auto value = static_cast<double>(bytes);
  for (const char* unit : {"bytes", "KiB", "MiB"}) {
    if (value < step)
      return fmt::format("{:.{}f} {}", value, value < 10 && unit[0] != 'b' ? 1 : 0, unit);
    value /= step;
  }
  return fmt::format("{:.1f} GiB", value);
}

}  // namespace

SceneFacts facts_of(const scene::LoadedScene& loaded, std::uint64_t decoded_bytes) {
  const scene::Scene& from = loaded.scene;
  SceneFacts out;
  out.name = from.name;
  out.width = from.render.width;
  out.height = from.render.height;
  const std::vector<Coordinates> kept = coordinates_kept(from);
  count(from.shapes, kept, out);
  out.triangles_placed = out.triangles;
  std::vector<std::uint64_t> of_object;
  for (const scene::Object& object : from.objects) {
    count(object.shapes, kept, out);
    of_object.push_back(triangles_of(object.shapes));
  }
  for (const scene::Instance& instance : from.instances)
    out.triangles_placed += of_object[instance.object];
  out.objects = from.objects.size();
  out.instances = from.instances.size();
  out.materials = from.materials.size();
  for (const scene::Material& material : from.materials)
    out.emitting_materials += emits(material) ? 1 : 0;
  out.lights = from.lights.size();
  out.environment = from.environment.has_value();
  out.film_transparent = from.film_transparent;
  out.shadow_catchers = scene::has_shadow_catchers(from);
  out.textures = from.textures.size();
  out.images = from.images.size();
  for (const scene::Image& image : from.images) out.image_bytes += scene::encoded_size(image);
  out.texture_bytes = decoded_bytes + decoded_bytes / 3;
  out.memory_bytes = out.texture_bytes + out.geometry_bytes +
                     out.triangles * hierarchy_bytes_of_triangle + out.instances * instance_bytes;
  for (const scene::Camera& camera : from.cameras) out.cameras.push_back(camera.name);
  out.duration = loaded.duration;
  out.files = loaded.files.size();
  for (const scene::UsedFile& used : loaded.files)
    out.file_bytes += std::filesystem::file_size(used.file);
  out.variants = loaded.variants;
  out.animations = loaded.animations;
  out.warnings = loaded.warnings;
  return out;
}

Json to_json(const SceneFacts& facts) {
  return {{"name", facts.name},
          {"width", facts.width},
          {"height", facts.height},
          {"film_transparent", facts.film_transparent},
          {"shadow_catchers", facts.shadow_catchers},
          {"triangles", facts.triangles},
          {"triangles_placed", facts.triangles_placed},
          {"spheres", facts.spheres},
          {"shapes", facts.shapes},
          {"objects", facts.objects},
          {"instances", facts.instances},
          {"materials", facts.materials},
          {"emitting_materials", facts.emitting_materials},
          {"lights", facts.lights},
          {"environment", facts.environment},
          {"textures", facts.textures},
          {"images", facts.images},
          {"image_bytes", facts.image_bytes},
          {"texture_bytes", facts.texture_bytes},
          {"geometry_bytes", facts.geometry_bytes},
          {"memory_bytes", facts.memory_bytes},
          {"cameras", facts.cameras},
          {"variants", facts.variants},
          {"animations", facts.animations},
          {"duration", facts.duration},
          {"files", facts.files},
          {"file_bytes", facts.file_bytes},
          {"warnings", facts.warnings}};
}

std::string text_of(const SceneFacts& facts) {
  std::string out;
  const auto line = [&](std::string_view what, const std::string& text) {
    out += fmt::format("{:<11} {}\n", what, text);
  };
  if (!facts.name.empty()) line("name", facts.name);
  line("film", fmt::format("{}x{}{}{}", facts.width, facts.height,
                           facts.film_transparent ? ", transparent" : "",
                           facts.shadow_catchers ? ", catches shadows" : ""));
  line("triangles", facts.instances == 0 ? fmt::format("{}", facts.triangles)
                                         : fmt::format("{}, {} with instances", facts.triangles,
                                                       facts.triangles_placed));
  if (facts.spheres > 0) line("spheres", fmt::format("{}", facts.spheres));
  line("shapes", fmt::format("{}", facts.shapes));
  if (facts.instances > 0)
    line("instances", fmt::format("{} of {} objects", facts.instances, facts.objects));
  line("materials", facts.emitting_materials == 0
                        ? fmt::format("{}", facts.materials)
                        : fmt::format("{}, {} emit", facts.materials, facts.emitting_materials));
  line("lights", fmt::format("{} without a size{}", facts.lights,
                             facts.environment ? ", and an environment" : ""));
  line("textures",
       fmt::format("{} of {} images, {} encoded, {} in memory", facts.textures, facts.images,
                   size_text(facts.image_bytes), size_text(facts.texture_bytes)));
  line("cameras", fmt::format("{}", fmt::join(facts.cameras, ", ")));
  if (!facts.variants.empty()) line("variants", fmt::format("{}", fmt::join(facts.variants, ", ")));
  if (!facts.animations.empty())
    line("animations", fmt::format("{}", fmt::join(facts.animations, ", ")));
  if (facts.duration > 0) line("moves for", fmt::format("{:.4g} s", facts.duration));
  line("memory", fmt::format("about {} in a worker", size_text(facts.memory_bytes)));
  line("files", fmt::format("{}, {}", facts.files, size_text(facts.file_bytes)));
  for (const std::string& warning : facts.warnings) line("note", warning);
  return out;
}

}  // namespace tessera::client
