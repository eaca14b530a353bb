#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "common/base/limits.hpp"
#include "common/scene/gltf/gltf.hpp"
#include "common/scene/parts.hpp"
#include "common/scene/texture_uses.hpp"

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

/// A glTF file, and how it joins the scene.
struct Inclusion {
  Value file;
  Transform to_world = {};
  Visibility visibility = {};
  std::string name = {};  ///< before those of its objects; empty: none
  gltf::Options options = {};

  /// Two of one key bring the same.
  using Key = std::tuple<std::string, std::optional<std::string>, gltf::Units>;
  [[nodiscard]] Key key() const { return {file.text(), options.variant, options.units}; }
};

/// A file that was read.
struct Part {
  Scene scene;                     ///< with the scene's numbers of materials and objects
  std::uint32_t first_object = 0;  ///< of its objects, which stand one after the other
  std::uint32_t end_object = 0;
  std::optional<std::uint32_t> whole;  ///< the object that its shapes are, if several stand
  std::vector<std::uint32_t> names;    ///< by those of its instances: the scene's, or none as yet
};

/// What the instances of a part are called where it is included. Each name is in the scene's list
/// once.
class InstanceNamer {
 public:
  InstanceNamer(Part& part, const std::string& name, const std::vector<Object>& objects,
                NameList& list)
      : part_(part), name_(name), objects_(objects), list_(list) {
    if (name.empty()) return;
    by_name_.resize(part.scene.instance_names.size(), NameList::none);
    by_object_.resize(part.end_object - part.first_object, NameList::none);
  }

  std::uint32_t operator()(const Instance& instance) {
    if (instance.name == NameList::none) return by_object(instance.object);
    std::uint32_t& number = (name_.empty() ? part_.names : by_name_)[instance.name];
    if (number == NameList::none)
      number = list_.add(within(part_.scene.instance_names[instance.name]));
    return number;
  }

  /// Behind the inclusion's name, if it has one.
  [[nodiscard]] std::string within(std::string_view name) const {
    return name_.empty() ? std::string(name) : fmt::format("{}/{}", name_, name);
  }

 private:
  /// Of one that has no name of its own.
  std::uint32_t by_object(std::uint32_t object) {
    if (name_.empty()) return NameList::none;
    std::uint32_t& number = by_object_[object - part_.first_object];
    if (number == NameList::none)
      number = list_.add(part_.whole == object ? name_ : within(objects_[object].name));
    return number;
  }

  Part& part_;
  const std::string& name_;
  const std::vector<Object>& objects_;
  NameList& list_;
  std::vector<std::uint32_t> by_name_, by_object_;  ///< the scene's, where the inclusion has a name
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
    Part& part = part_of(wanted, several);
    InstanceNamer name_of(part, wanted.name, out_.objects, out_.instance_names);
    const Transform& to_world = wanted.to_world;
    if (!several)
      for (Shape& shape : part.scene.shapes) {
        shape.name = name_of.within(shape.name);
        shape.to_world = to_world * shape.to_world;
        shape.visibility = wanted.visibility;
        out_.shapes.push_back(std::move(shape));
      }
    for (const Instance& instance : part.scene.instances)
      out_.instances.push_back(
          {instance.object, to_world * instance.to_world, wanted.visibility, name_of(instance)});
    take_named(part.scene.lights, out_.lights, own_lights_, to_world);
    // No two cameras have one name: --camera could not tell them apart.
    take_named(part.scene.cameras, out_.cameras, out_.cameras.size(), to_world);
  }

 private:
  /// Where several of it will stand, its shapes are an object of which each is an instance.
  Part& part_of(const Inclusion& wanted, bool several) {
    const auto [found, fresh] = parts_.try_emplace(wanted.key());
    Part& read = found->second;
    if (!fresh) return read;
    read.scene = reading_.load_part(wanted.file, wanted.options);
    Scene& part = read.scene;
    take_materials(part, wanted.file);
    const auto renumber = [&](std::vector<Shape>& shapes) {
      for (Shape& shape : shapes) shape.material = materials_[shape.material];
    };
    read.first_object = static_cast<std::uint32_t>(out_.objects.size());
    for (Object& object : part.objects) {
      renumber(object.shapes);
      out_.objects.push_back(std::move(object));
    }
    for (Instance& instance : part.instances) instance.object += read.first_object;
    renumber(part.shapes);
    if (several && !part.shapes.empty()) {
      read.whole = static_cast<std::uint32_t>(out_.objects.size());
      part.instances.push_back({*read.whole, {}});
      out_.objects.push_back({wanted.file.text(), std::move(part.shapes)});
    }
    read.end_object = static_cast<std::uint32_t>(out_.objects.size());
    read.names.resize(part.instance_names.size(), NameList::none);
    return read;
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
      if (reading_.materials.size() == limits::materials_max)
        file.fail(
            fmt::format("with it the scene has more than {} materials", limits::materials_max));
      for (TextureUse* use : texture_uses(material)) use->texture += first_texture;
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
  std::map<Inclusion::Key, Part> parts_;
};

Inclusion read_inclusion(const Value& item, const Reading& reading) {
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
  out.visibility = read_visibility(in, reading);
  if (const auto name = in.optional("name")) out.name = plain_name(*name);
  in.finish();
  return out;
}

}  // namespace

void read_includes(const Value& list, Reading& reading, Scene& out) {
  std::vector<Inclusion> wanted;
  std::map<Inclusion::Key, int> count;
  for (const Value& item : list.items("a list of glTF files, each a name or {\"file\": …}")) {
    wanted.push_back(read_inclusion(item, reading));
    ++count[wanted.back().key()];
  }
  Includer includer(reading, out);
  for (const Inclusion& one : wanted) includer.add(one, count[one.key()] > 1);
}

}  // namespace tessera::scene
