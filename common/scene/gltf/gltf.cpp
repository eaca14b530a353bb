#include "common/scene/gltf/gltf.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "common/base/names.hpp"
#include "common/scene/default_view.hpp"
#include "common/scene/gltf/accessor.hpp"
#include "common/scene/gltf/cameras.hpp"
#include "common/scene/gltf/instancing.hpp"
#include "common/scene/gltf/lights.hpp"
#include "common/scene/gltf/limits.hpp"
#include "common/scene/gltf/materials.hpp"
#include "common/scene/gltf/mesh.hpp"
#include "common/scene/gltf/nodes.hpp"

namespace tessera::scene::gltf {

namespace {

constexpr int film_height = 540;
constexpr double film_aspect = 16.0 / 9.0;

/// Puts a file's parts together into a scene.
class Assembler {
 public:
  Assembler(Asset& asset, bool meshes)
      : asset_(asset), meshes_(meshes), accessors_(asset), materials_(asset) {}

  Scene assemble() {
    const std::vector<PlacedNode> nodes = placed_nodes(asset_);
    scene_.cameras = read_cameras(asset_, nodes);
    scene_.lights = read_lights(asset_, nodes);
    const double aspect =
        std::clamp(aspect_of_first(asset_, nodes).value_or(film_aspect), 0.05, 20.0);
    scene_.render.height = film_height;
    scene_.render.width = static_cast<int>(std::lround(film_height * aspect));
    if (meshes_) {
      find_places(nodes);
      for (std::size_t mesh = 0; mesh < places_.size(); ++mesh)
        if (!places_[mesh].empty()) add_mesh(mesh);
    }
    materials_.move_into(scene_);
    warn_of_the_rest();
    fill_in(aspect);
    return std::move(scene_);
  }

 private:
  /// Where each mesh stands.
  void find_places(const std::vector<PlacedNode>& nodes) {
    places_.resize(asset_.model.meshes.size());
    std::size_t count = 0;
    for (const PlacedNode& placed : nodes) {
      const tinygltf::Node& node = asset_.model.nodes[static_cast<std::size_t>(placed.node)];
      if (node.mesh < 0) continue;
      std::vector<Transform>& places = places_[static_cast<std::size_t>(node.mesh)];
      for (const Transform& copy : copies_of(asset_, accessors_, placed.node)) {
        const Transform to_world = placed.to_world * copy;
        if (is_singular(to_world)) {
          asset_.warn(
              fmt::format("/nodes/{} is scaled to something flat, and left out", placed.node));
          continue;
        }
        if (++count > limits::gltf_instances)
          throw Error(ErrorKind::too_large,
                      fmt::format("more than {} meshes are placed", limits::gltf_instances),
                      {.file = asset_.name, .key = fmt::format("/nodes/{}", placed.node)});
        places.push_back(to_world);
      }
    }
  }

  void add_mesh(std::size_t mesh) {
    std::vector<Shape> shapes = shapes_of(mesh);
    if (shapes.empty()) return;
    const std::vector<Transform>& places = places_[mesh];
    if (places.size() == 1) {
      for (Shape& shape : shapes) {
        shape.to_world = places[0];
        scene_.shapes.push_back(std::move(shape));
      }
      return;
    }
    const auto object = static_cast<std::uint32_t>(scene_.objects.size());
    scene_.objects.push_back({.name = shapes[0].name, .shapes = std::move(shapes)});
    for (const Transform& to_world : places)
      scene_.instances.push_back({.object = object, .to_world = to_world});
  }

  std::vector<Shape> shapes_of(std::size_t number) {
    const tinygltf::Mesh& mesh = asset_.model.meshes[number];
    const std::string name =
        mesh.name.empty() ? fmt::format("mesh {}", number) : excerpt(mesh.name, 120);
    std::vector<Shape> out;
    for (std::size_t i = 0; i < mesh.primitives.size(); ++i) {
      const tinygltf::Primitive& primitive = mesh.primitives[i];
      const std::string place = fmt::format("/meshes/{}/primitives/{}", number, i);
      auto geometry = read_primitive(asset_, accessors_, primitive, place);
      if (!geometry) continue;
      out.push_back({.name = name,
                     .geometry = std::move(*geometry),
                     .material = materials_.use(primitive.material),
                     .to_world = {}});
    }
    return out;
  }

  void warn_of_the_rest() {
    const tinygltf::Model& model = asset_.model;
    if (!model.animations.empty()) asset_.warn("animations are not supported; nothing moves");
    if (!model.skins.empty()) asset_.warn("skins are not supported; meshes stand as modelled");
    const auto has_targets = [](const tinygltf::Mesh& mesh) {
      return std::any_of(mesh.primitives.begin(), mesh.primitives.end(),
                         [](const auto& primitive) { return !primitive.targets.empty(); });
    };
    if (std::any_of(model.meshes.begin(), model.meshes.end(), has_targets))
      asset_.warn("morph targets are not supported; meshes stand as modelled");
    if (extension(model.extensions, "KHR_materials_variants") != nullptr)
      asset_.warn("the file has variants of its materials; the default is shown");
  }

  /// What a picture needs, and the file does not have.
  void fill_in(double aspect) {
    if (scene_.cameras.empty()) {
      scene_.cameras.push_back(view_of(bounds_of(scene_), aspect));
      scene_.cameras.back().name = "camera";
      if (meshes_) asset_.warn("the file has no camera: this one shows all of it");
    }
    if (!materials_.emits() && scene_.lights.empty()) {
      scene_.environment = studio_environment();
      if (meshes_) asset_.warn("the file has no light: even light comes from every direction");
    }
  }

  Asset& asset_;
  bool meshes_;
  Accessors accessors_;
  Materials materials_;
  std::vector<std::vector<Transform>> places_;  ///< by mesh
  Scene scene_;
};

}  // namespace

bool is_gltf(std::string_view path) {
  std::string ending(path.substr(std::min(path.rfind('.'), path.size())));
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending == ".gltf" || ending == ".glb";
}

LoadedScene load(const SceneFiles& files, const std::string& path, bool meshes) {
  Asset asset = read_asset(files, path);
  LoadedScene out;
  out.files.push_back({path, files.locate(path)});
  for (const UsedFile& used : asset.files)
    if (used.path != path) out.files.push_back(used);
  out.scene = Assembler(asset, meshes).assemble();
  out.warnings = std::move(asset.warnings);
  return out;
}

}  // namespace tessera::scene::gltf
