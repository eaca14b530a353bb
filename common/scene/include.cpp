#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/scene/gltf/gltf.hpp"
#include "common/scene/parts.hpp"

namespace tessera::scene {

namespace {

Vec3 moved_point(const Transform& t, const Vec3& p) {
  Vec3 out{};
  for (std::size_t i = 0; i < 3; ++i)
    out[i] = t.m[4 * i] * p[0] + t.m[4 * i + 1] * p[1] + t.m[4 * i + 2] * p[2] + t.m[4 * i + 3];
  return out;
}

Vec3 moved_direction(const Transform& t, const Vec3& d) {
  Vec3 out{};
  for (std::size_t i = 0; i < 3; ++i)
    out[i] = t.m[4 * i] * d[0] + t.m[4 * i + 1] * d[1] + t.m[4 * i + 2] * d[2];
  return out;
}

void move(Camera& camera, const Transform& t) {
  camera.eye = moved_point(t, camera.eye);
  camera.target = moved_point(t, camera.target);
  camera.up = moved_direction(t, camera.up);
  const double scale = uniform_scale(t).value_or(1);
  camera.orthographic_height *= scale;
  camera.lens.radius *= scale;
  camera.lens.focus_distance *= scale;
}

void move(PunctualLight& light, const Transform& t) {
  if (auto* point = std::get_if<PointLight>(&light.shape)) {
    point->position = moved_point(t, point->position);
  } else if (auto* spot = std::get_if<SpotLight>(&light.shape)) {
    spot->position = moved_point(t, spot->position);
    spot->direction = moved_direction(t, spot->direction);
  } else {
    auto& far = std::get<DirectionalLight>(light.shape);
    far.direction = moved_direction(t, far.direction);
  }
}

/// The textures that a material looks up, each of its uses.
std::vector<TextureUse*> uses_of(Material& material) {
  std::vector<TextureUse*> out;
  const auto add = [&](std::optional<TextureUse>& use) {
    if (use) out.push_back(&*use);
  };
  if (auto* surface = std::get_if<Principled>(&material.surface)) {
    for (ColorInput* input : {&surface->base_color, &surface->specular_color, &surface->emission})
      add(input->texture);
    for (ScalarInput* input :
         {&surface->metallic, &surface->roughness, &surface->specular, &surface->transmission,
          &surface->clearcoat, &surface->clearcoat_roughness, &surface->anisotropy})
      add(input->texture);
    add(surface->anisotropy_direction);
    if (surface->clearcoat_normal) out.push_back(&surface->clearcoat_normal->texture);
  }
  add(material.opacity.alpha.texture);
  if (material.normal_map) out.push_back(&material.normal_map->texture);
  if (material.bump_map) out.push_back(&material.bump_map->texture);
  return out;
}

class Includer {
 public:
  Includer(Reading& reading, Scene& out)
      : reading_(reading),
        out_(out),
        own_materials_(reading.materials.size()),
        own_lights_(out.lights.size()) {}

  void add(const Value& file, const Transform& to_world, const gltf::Options& options) {
    if (!gltf::is_gltf(file.text()))
      file.fail_expected("the name of a glTF file, which ends in .gltf or .glb");
    Scene part = reading_.load_part(file, options);
    take_materials(part, file);
    const auto first_object = static_cast<std::uint32_t>(out_.objects.size());
    for (Object& object : part.objects) {
      for (Shape& shape : object.shapes) shape.material = materials_[shape.material];
      out_.objects.push_back(std::move(object));
    }
    for (Instance& instance : part.instances) {
      instance.object += first_object;
      instance.to_world = to_world * instance.to_world;
      out_.instances.push_back(instance);
    }
    for (Shape& shape : part.shapes) {
      shape.material = materials_[shape.material];
      shape.to_world = to_world * shape.to_world;
      out_.shapes.push_back(std::move(shape));
    }
    take_named(part.lights, out_.lights, own_lights_, to_world);
    // No two cameras have one name: --camera could not tell them apart.
    take_named(part.cameras, out_.cameras, out_.cameras.size(), to_world);
  }

 private:
  /// A material of the scene's own takes the place of an included one of its name.
  void take_materials(Scene& part, const Value& file) {
    const auto first_image = static_cast<std::uint32_t>(out_.images.size());
    const auto first_texture = static_cast<std::uint32_t>(out_.textures.size());
    std::move(part.images.begin(), part.images.end(), std::back_inserter(out_.images));
    for (Texture& texture : part.textures) {
      texture.image += first_image;
      out_.textures.push_back(texture);
    }
    materials_.clear();
    for (Material& material : part.materials) {
      const auto end = reading_.materials.begin() + static_cast<std::ptrdiff_t>(own_materials_);
      const auto same = std::find_if(reading_.materials.begin(), end, [&](const Material& other) {
        return other.name == material.name;
      });
      materials_.push_back(static_cast<std::uint32_t>(
          same != end ? same - reading_.materials.begin()
                      : static_cast<std::ptrdiff_t>(reading_.materials.size())));
      if (same != end) continue;
      if (reading_.materials.size() == materials_most)
        file.fail(fmt::format("with it the scene has more than {} materials", materials_most));
      for (TextureUse* use : uses_of(material)) use->texture += first_texture;
      reading_.materials.push_back(std::move(material));
    }
  }

  /// Behind those that are there; one of the first `own` takes the place of an included one of its
  /// name.
  template <class Named>
  static void take_named(std::vector<Named>& from, std::vector<Named>& to, std::size_t own,
                         const Transform& to_world) {
    for (Named& one : from) {
      const auto end = to.begin() + static_cast<std::ptrdiff_t>(own);
      if (std::any_of(to.begin(), end, [&](const Named& other) { return other.name == one.name; }))
        continue;
      move(one, to_world);
      to.push_back(std::move(one));
    }
  }

  Reading& reading_;
  Scene& out_;
  std::size_t own_materials_, own_lights_;  ///< the scene's; included ones stand behind them
  std::vector<std::uint32_t> materials_;    ///< of the part → of the scene
};

}  // namespace

void read_includes(const Value& list, Reading& reading, Scene& out) {
  Includer includer(reading, out);
  for (const Value& item : list.items("a list of glTF files, each a name or {\"file\": …}")) {
    if (item.kind() == Kind::text) {
      includer.add(item, Transform{}, {});
      continue;
    }
    Fields in(item);
    const Value file = in.required("file");
    const auto transform = in.optional("transform");
    gltf::Options options;
    if (const auto variant = in.optional("variant")) options.variant = variant->text();
    if (const auto units = in.optional("units"))
      options.units = read_word(*units, "units", gltf::unit_names);
    in.finish();
    includer.add(file, transform ? read_transform(*transform) : Transform{}, options);
  }
}

}  // namespace tessera::scene
