#include "common/scene/gltf/gltf.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "common/base/limits.hpp"
#include "common/base/names.hpp"
#include "common/scene/gltf/accessor.hpp"
#include "common/scene/gltf/animation.hpp"
#include "common/scene/gltf/cameras.hpp"
#include "common/scene/gltf/instancing.hpp"
#include "common/scene/gltf/lights.hpp"
#include "common/scene/gltf/materials.hpp"
#include "common/scene/gltf/mesh.hpp"
#include "common/scene/gltf/nodes.hpp"
#include "common/scene/gltf/pose.hpp"
#include "common/scene/outline.hpp"

namespace tessera::scene::gltf {

namespace {

constexpr int film_height = 540;
constexpr double film_aspect = 16.0 / 9.0;
constexpr std::size_t name_most = 120;  ///< bytes of an object's name

std::vector<std::string> variants_of(const Asset& asset) {
  std::vector<std::string> out;
  const auto* all = extension(asset.model.extensions, "KHR_materials_variants");
  const auto* list = all == nullptr ? nullptr : member(*all, "variants");
  for (std::size_t i = 0; list != nullptr && i < list->ArrayLen(); ++i)
    out.push_back(text_or(list->Get(static_cast<int>(i)), "name", ""));
  return out;
}

std::vector<std::string> animations_of(const Asset& asset) {
  std::vector<std::string> out;
  for (const tinygltf::Animation& animation : asset.model.animations)
    out.push_back(animation.name.empty() ? fmt::format("animation {}", out.size())
                                         : excerpt(animation.name, 120));
  return out;
}

/// Where a node shows its mesh, in the world.
struct Place {
  Transform to_world;
  int node = 0;
};

/// Puts a file's parts together into a scene.
class Assembler {
 public:
  Assembler(Asset& asset, const Options& options)
      : asset_(asset), options_(options), accessors_(asset), materials_(asset) {}

  LoadedScene assemble() {
    find_variant();
    out_.duration = last_key(asset_, accessors_);
    animate(asset_, accessors_, options_.moment.time);
    const std::vector<PlacedNode> nodes = placed_nodes(asset_);
    scene_.cameras = read_cameras(asset_, nodes);
    scene_.lights = read_lights(asset_, nodes, options_.units);
    const double aspect =
        std::clamp(aspect_of_first(asset_, nodes).value_or(film_aspect), 0.05, 20.0);
    scene_.render.height = film_height;
    scene_.render.width = static_cast<int>(std::lround(film_height * aspect));
    find_places(nodes);
    for (std::size_t mesh = 0; mesh < places_.size(); ++mesh)
      if (!places_[mesh].empty()) add_mesh(mesh, {}, places_[mesh], places_[mesh].front().node);
    materials_.move_into(scene_);
    warn_of_the_rest();
    if (options_.whole) fill_in(aspect);
    out_.scene = std::move(scene_);
    return std::move(out_);
  }

 private:
  void find_variant() {
    if (!options_.variant) return;
    const std::vector<std::string> names = variants_of(asset_);
    const auto found = std::find(names.begin(), names.end(), *options_.variant);
    if (names.empty())
      asset_.fail(
          "", fmt::format("unknown variant \"{}\": the file has none", excerpt(*options_.variant)));
    if (found == names.end())
      asset_.fail("/extensions/KHR_materials_variants/variants",
                  unknown_name("variant", *options_.variant, {names.begin(), names.end()}));
    variant_ = static_cast<int>(found - names.begin());
  }

  /// Of the variant that is shown.
  [[nodiscard]] int material_of(const tinygltf::Primitive& primitive) const {
    const auto* variants = extension(primitive.extensions, "KHR_materials_variants");
    if (variant_ < 0 || variants == nullptr) return primitive.material;
    const tinygltf::Value& mappings = variants->Get("mappings");
    for (std::size_t i = 0; i < mappings.ArrayLen(); ++i) {
      const tinygltf::Value& mapping = mappings.Get(static_cast<int>(i));
      const tinygltf::Value& of = mapping.Get("variants");
      for (std::size_t k = 0; k < of.ArrayLen(); ++k)
        if (of.Get(static_cast<int>(k)).GetNumberAsInt() == variant_)
          return integer_or(mapping, "material", primitive.material);
    }
    return primitive.material;
  }

  /// Where each mesh stands; what is bent stands apart.
  void find_places(const std::vector<PlacedNode>& nodes) {
    places_.resize(asset_.model.meshes.size());
    std::vector<const Transform*> worlds(asset_.model.nodes.size(), nullptr);
    for (const PlacedNode& placed : nodes)
      worlds[static_cast<std::size_t>(placed.node)] = &placed.to_world;
    for (const PlacedNode& placed : nodes) {
      const tinygltf::Node& node = asset_.model.nodes[static_cast<std::size_t>(placed.node)];
      if (node.mesh < 0) continue;
      const Pose pose = pose_of(asset_, accessors_, placed.node, worlds);
      std::vector<Place> places = places_of(placed);
      if (is_bent(pose))
        add_mesh(static_cast<std::size_t>(node.mesh), pose, places, placed.node);
      else
        append(places_[static_cast<std::size_t>(node.mesh)], std::move(places));
    }
  }

  static bool is_bent(const Pose& pose) {
    return !pose.joints.empty() || std::any_of(pose.weights.begin(), pose.weights.end(),
                                               [](double weight) { return weight != 0; });
  }

  static void append(std::vector<Place>& to, std::vector<Place> more) {
    if (to.empty())
      to = std::move(more);
    else
      to.insert(to.end(), more.begin(), more.end());
  }

  std::vector<Place> places_of(const PlacedNode& placed) {
    std::vector<Place> out;
    for (const Transform& copy : copies_of(asset_, accessors_, placed.node)) {
      const Transform to_world = placed.to_world * copy;
      if (is_singular(to_world)) {
        asset_.warn(
            fmt::format("/nodes/{} is scaled to something flat, and left out", placed.node));
        continue;
      }
      if (++count_ > limits::gltf_instances)
        throw Error(ErrorKind::too_large,
                    fmt::format("more than {} meshes are placed", limits::gltf_instances),
                    {.file = asset_.name, .key = fmt::format("/nodes/{}", placed.node)});
      out.push_back({to_world, placed.node});
    }
    return out;
  }

  /// A node's, which is what people see in their programs, or its mesh's.
  [[nodiscard]] std::string name_of(int node, const std::string& mesh) const {
    const std::string& own = asset_.model.nodes[static_cast<std::size_t>(node)].name;
    return own.empty() ? mesh : excerpt(own, name_most);
  }

  /// `node`: the first that shows it.
  void add_mesh(std::size_t number, const Pose& pose, const std::vector<Place>& places, int node) {
    const tinygltf::Mesh& mesh = asset_.model.meshes[number];
    const std::string mesh_name =
        mesh.name.empty() ? fmt::format("mesh {}", number) : excerpt(mesh.name, name_most);
    const std::string name = places.size() > 1 ? mesh_name : name_of(node, mesh_name);
    std::vector<Shape> shapes;
    for (std::size_t i = 0; i < mesh.primitives.size(); ++i) {
      const tinygltf::Primitive& primitive = mesh.primitives[i];
      auto made = read_primitive(asset_, accessors_, primitive, pose,
                                 fmt::format("/meshes/{}/primitives/{}", number, i));
      if (!made) continue;
      if (options_.keep == Keep::outlines) keep_outline(made->mesh);
      Shape shape{.name = name,
                  .geometry = std::move(made->mesh),
                  .material = materials_.use(material_of(primitive)),
                  .to_world = {}};
      (made->in_world ? scene_.shapes : shapes).push_back(std::move(shape));
    }
    place(mesh_name, std::move(shapes), places);
  }

  void place(const std::string& mesh_name, std::vector<Shape> shapes,
             const std::vector<Place>& places) {
    if (shapes.empty() || places.empty()) return;
    if (places.size() == 1) {
      for (Shape& shape : shapes) {
        shape.to_world = places[0].to_world;
        scene_.shapes.push_back(std::move(shape));
      }
      return;
    }
    const auto object = static_cast<std::uint32_t>(scene_.objects.size());
    scene_.objects.push_back({.name = mesh_name, .shapes = std::move(shapes)});
    // A node's places stand together, and share its name.
    std::uint32_t name = NameList::none;
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (i == 0 || places[i].node != places[i - 1].node) name = instance_name(places[i].node);
      scene_.instances.push_back({.object = object, .to_world = places[i].to_world, .name = name});
    }
  }

  std::uint32_t instance_name(int node) {
    const std::string name = name_of(node, {});
    return name.empty() ? NameList::none : scene_.instance_names.add(name);
  }

  /// Of data of vertices that no picture shows.
  void warn_of_attributes() {
    for (const tinygltf::Mesh& mesh : asset_.model.meshes)
      for (const tinygltf::Primitive& primitive : mesh.primitives) {
        for (const auto& [name, accessor] : primitive.attributes)
          if ((name.starts_with("TEXCOORD_") && name != "TEXCOORD_0" && name != "TEXCOORD_1") ||
              (name.starts_with("COLOR_") && name != "COLOR_0"))
            asset_.warn(
                "vertices' colours beyond the first set and texture coordinates beyond the "
                "second are passed over");
        for (const auto& target : primitive.targets)
          for (const auto& [name, accessor] : target)
            if (name.starts_with("TEXCOORD_") || name.starts_with("COLOR_"))
              asset_.warn("morph targets' colours and texture coordinates are passed over");
      }
  }

  void warn_of_the_rest() {
    warn_of_attributes();
    if (options_.units == Units::physical && !scene_.lights.empty() &&
        asset_.model.asset.generator.find("Blender") != std::string::npos)
      asset_.warn(
          "Blender wrote it: if its lighting mode was Standard, lights are 683 times what they are "
          "there, and --units blender divides them by that");
    if (const auto names = variants_of(asset_); !names.empty() && variant_ < 0)
      asset_.warn(fmt::format("the file has variants of its materials ({}); the default is shown",
                              fmt::join(names, ", ")));
  }

  /// What a picture needs, and the file does not have.
  void fill_in(double aspect) {
    out_.made_up = make_up(scene_, aspect, options_.moment.made_up);
    if (out_.made_up.camera) asset_.warn("the file has no camera: this one shows all of it");
    if (out_.made_up.light) asset_.warn("the file has no light: it is given that of a studio");
  }

  Asset& asset_;
  Options options_;
  Accessors accessors_;
  Materials materials_;
  std::vector<std::vector<Place>> places_;  ///< by mesh; of those that are not bent
  std::size_t count_ = 0;                   ///< of places
  int variant_ = -1;                        ///< that is shown; −1: the default
  Scene scene_;
  LoadedScene out_;
};

}  // namespace

bool is_gltf(std::string_view path) {
  std::string ending(path.substr(std::min(path.rfind('.'), path.size())));
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending == ".gltf" || ending == ".glb";
}

LoadedScene load(const SceneFiles& files, const std::string& path, const Options& options) {
  Asset asset = read_asset(files, path);
  LoadedScene out;
  if (asset.problems.empty())
    out = Assembler(asset, options).assemble();
  else
    out.scene.images = std::move(asset.images);
  out.files.push_back({path, files.locate(path)});
  for (const UsedFile& used : asset.files)
    if (used.path != path) out.files.push_back(used);
  out.variants = variants_of(asset);
  out.animations = animations_of(asset);
  out.warnings = std::move(asset.warnings);
  out.problems = std::move(asset.problems);
  return out;
}

}  // namespace tessera::scene::gltf
