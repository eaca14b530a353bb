#include "tests/fuzz/scene.hpp"

#include <cmath>
#include <initializer_list>

#include "tests/fuzz/mesh.hpp"

namespace tessera::fuzz {

namespace {

class Checker {
 public:
  explicit Checker(const scene::Scene& scene) : scene_(scene) {}

  void run() const {
    require(!scene_.cameras.empty(), "a scene has a camera");
    for (const scene::Camera& camera : scene_.cameras) check(camera);
    for (const scene::Texture& texture : scene_.textures)
      require(texture.image < scene_.images.size(), "a texture has its image");
    for (const scene::Material& material : scene_.materials) check(material);
    for (const scene::Shape& shape : scene_.shapes) check(shape);
    for (const scene::Object& object : scene_.objects)
      for (const scene::Shape& shape : object.shapes) check(shape);
    for (const scene::Instance& instance : scene_.instances) {
      require(instance.object < scene_.objects.size(), "an instance has its object");
      require(
          instance.name == scene::NameList::none || instance.name < scene_.instance_names.size(),
          "an instance has its name");
      check(instance.to_world);
    }
    if (scene_.environment && scene_.environment->image)
      require(*scene_.environment->image < scene_.images.size(), "an environment has its image");
  }

 private:
  template <class Numbers>
  static void check_finite(const Numbers& numbers) {
    for (const double x : numbers) require(std::isfinite(x), "a number is finite");
  }
  static void check(const scene::Camera& camera) {
    for (const scene::Vec3* one : {&camera.eye, &camera.target, &camera.up}) check_finite(*one);
    require(camera.projection != scene::Projection::perspective ||
                (camera.fov_y_degrees > 0 && camera.fov_y_degrees < 180),
            "a camera sees something");
  }
  static void check(const scene::Transform& transform) {
    check_finite(transform.m);
    require(!is_singular(transform), "a transform can be undone");
  }
  void check(const scene::Shape& shape) const {
    require(shape.material < scene_.materials.size(), "a shape has its material");
    check(shape.to_world);
    if (const auto* mesh = std::get_if<scene::Mesh>(&shape.geometry)) fuzz::check(*mesh);
  }
  void check(const scene::TextureUse& use) const {
    require(use.texture < scene_.textures.size() && use.uv_set <= 1, "an input has its texture");
    check_finite(use.to_uv);
  }
  template <class Input>
  void check_input(const Input& input) const {
    if (input.texture) check(*input.texture);
  }
  void check(const scene::Material& material) const {
    check_input(material.opacity.alpha);
    if (material.normal_map) check(material.normal_map->texture);
    if (material.bump_map) check(material.bump_map->texture);
    if (const auto* mix = std::get_if<scene::Mix>(&material.surface)) {
      require(mix->first < scene_.materials.size() && mix->second < scene_.materials.size(),
              "a mix has its materials");
      check_input(mix->amount);
    }
    const auto* surface = std::get_if<scene::Principled>(&material.surface);
    if (surface == nullptr) return;
    for (const scene::ColorInput* input :
         {&surface->base_color, &surface->specular_color, &surface->emission}) {
      check_finite(input->factor);
      check_input(*input);
    }
    for (const scene::ScalarInput* input :
         {&surface->metallic, &surface->roughness, &surface->specular, &surface->transmission,
          &surface->clearcoat, &surface->clearcoat_roughness, &surface->anisotropy})
      check_input(*input);
  }

  const scene::Scene& scene_;
};

}  // namespace

void check(const scene::Scene& scene) { Checker(scene).run(); }

}  // namespace tessera::fuzz
