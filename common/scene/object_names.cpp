#include "common/scene/object_names.hpp"

#include <unordered_map>

namespace tessera::scene {

namespace {
/// Numbers names in the order in which they come.
class Numbers {
 public:
  explicit Numbers(std::vector<std::string_view>& names) : names_(names) {}
  std::uint32_t operator()(std::string_view name) {
    const auto [found, fresh] = numbers_.emplace(name, static_cast<std::uint32_t>(names_.size()));
    if (fresh) names_.push_back(name);
    return found->second;
  }

 private:
  std::vector<std::string_view>& names_;
  std::unordered_map<std::string_view, std::uint32_t> numbers_;
};
}  // namespace

std::string_view name_of(const Scene& scene, const Instance& instance) {
  if (instance.name == NameList::none) return scene.objects[instance.object].name;
  return scene.instance_names[instance.name];
}

ObjectNames object_names(const Scene& scene) {
  ObjectNames out;
  Numbers number_of(out.names);
  for (const Shape& shape : scene.shapes) out.of_shape.push_back(number_of(shape.name));
  for (const Instance& instance : scene.instances)
    out.of_instance.push_back(number_of(name_of(scene, instance)));
  return out;
}

MaterialNames material_names(const Scene& scene) {
  MaterialNames out;
  Numbers number_of(out.names);
  for (const Material& material : scene.materials)
    out.of_material.push_back(number_of(material.name));
  return out;
}

}  // namespace tessera::scene
