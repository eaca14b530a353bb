#include "common/scene/object_names.hpp"

#include <unordered_map>

namespace tessera::scene {

namespace {
/// Numbers names in the order in which they come.
class Numbers {
 public:
  explicit Numbers(std::vector<std::string>& names) : names_(names) {}
  std::uint32_t operator()(const std::string& name) {
    const auto [found, fresh] = numbers_.emplace(name, static_cast<std::uint32_t>(names_.size()));
    if (fresh) names_.push_back(name);
    return found->second;
  }

 private:
  std::vector<std::string>& names_;
  std::unordered_map<std::string, std::uint32_t> numbers_;
};
}  // namespace

ObjectNames object_names(const Scene& scene) {
  ObjectNames out;
  Numbers number_of(out.names);
  for (const Shape& shape : scene.shapes) out.of_shape.push_back(number_of(shape.name));
  for (const Instance& instance : scene.instances)
    out.of_instance.push_back(
        number_of(instance.name.empty() ? scene.objects[instance.object].name : instance.name));
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
