#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

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

/// A glTF file, and how it joins the scene.
struct Inclusion {
  Value file;
  Transform to_world = {};
  Visibility visibility = {};
  gltf::Options options = {};

  /// Two of one key bring the same.
  using Key = std::tuple<std::string, std::optional<std::string>, gltf::Units>;
  [[nodiscard]] Key key() const { return {file.text(), options.variant, options.units}; }
};

class Includer {
 public:
  Includer(Reading& reading, Scene& out)
      : reading_(reading),
        out_(out),
        own_materials_(reading.materials.size()),
        own_lights_(out.lights.size()) {}

  /// `several`: it is not the only one of its key. What a file brings is in memory once.
  void add(const Inclusion& wanted, bool several) {
    Scene& part = part_of(wanted, several);
    const Transform& to_world = wanted.to_world;
    if (!several)
      for (Shape& shape : part.shapes) {
        shape.to_world = to_world * shape.to_world;
        shape.visibility = wanted.visibility;
        out_.shapes.push_back(std::move(shape));
      }
    for (const Instance& instance : part.instances)
      out_.instances.push_back(
          {instance.object, to_world * instance.to_world, wanted.visibility, instance.name});
    take_named(part.lights, out_.lights, own_lights_, to_world);
    // No two cameras have one name: --camera could not tell them apart.
    take_named(part.cameras, out_.cameras, out_.cameras.size(), to_world);
  }

 private:
  /// Where several of it will stand, its shapes are an object of which each is an instance.
  Scene& part_of(const Inclusion& wanted, bool several) {
    const auto [found, fresh] = parts_.try_emplace(wanted.key());
    Scene& part = found->second;
    if (!fresh) return part;
    part = reading_.load_part(wanted.file, wanted.options);
    take_materials(part, wanted.file);
    const auto renumber = [&](std::vector<Shape>& shapes) {
      for (Shape& shape : shapes) shape.material = materials_[shape.material];
    };
    const auto first_object = static_cast<std::uint32_t>(out_.objects.size());
    for (Object& object : part.objects) {
      renumber(object.shapes);
      out_.objects.push_back(std::move(object));
    }
    for (Instance& instance : part.instances) instance.object += first_object;
    renumber(part.shapes);
    if (several && !part.shapes.empty()) {
      part.instances.push_back({static_cast<std::uint32_t>(out_.objects.size()), {}});
      out_.objects.push_back({wanted.file.text(), std::move(part.shapes)});
    }
    return part;
  }

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
  static void take_named(const std::vector<Named>& from, std::vector<Named>& to, std::size_t own,
                         const Transform& to_world) {
    for (Named one : from) {
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
  /// Files that were read, with the scene's numbers of materials and objects.
  std::map<Inclusion::Key, Scene> parts_;
};

Inclusion read_inclusion(const Value& item) {
  const auto checked = [](const Value& file) {
    if (!gltf::is_gltf(file.text()))
      file.fail_expected("the name of a glTF file, which ends in .gltf or .glb");
    return file;
  };
  if (item.kind() == Kind::text) return Inclusion{.file = checked(item)};
  Fields in(item);
  Inclusion out{.file = checked(in.required("file"))};
  if (const auto transform = in.optional("transform")) out.to_world = read_transform(*transform);
  if (const auto variant = in.optional("variant")) out.options.variant = variant->text();
  if (const auto units = in.optional("units"))
    out.options.units = read_word(*units, "units", gltf::unit_names);
  out.visibility = read_visibility(in);
  in.finish();
  return out;
}

}  // namespace

void read_includes(const Value& list, Reading& reading, Scene& out) {
  std::vector<Inclusion> wanted;
  std::map<Inclusion::Key, int> count;
  for (const Value& item : list.items("a list of glTF files, each a name or {\"file\": …}")) {
    wanted.push_back(read_inclusion(item));
    ++count[wanted.back().key()];
  }
  Includer includer(reading, out);
  for (const Inclusion& one : wanted) includer.add(one, count[one.key()] > 1);
}

}  // namespace tessera::scene
