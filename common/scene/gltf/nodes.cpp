#include "common/scene/gltf/nodes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/base/limits.hpp"

namespace tessera::scene::gltf {

namespace {

std::vector<int> nodes_without_parent(const tinygltf::Model& model) {
  std::vector<bool> is_child(model.nodes.size(), false);
  for (const tinygltf::Node& node : model.nodes)
    for (const int child : node.children) is_child[static_cast<std::size_t>(child)] = true;
  std::vector<int> out;
  for (std::size_t i = 0; i < model.nodes.size(); ++i)
    if (!is_child[i]) out.push_back(static_cast<int>(i));
  return out;
}

class Walk {
 public:
  explicit Walk(Asset& asset) : asset_(asset), seen_(asset.model.nodes.size(), false) {}

  std::vector<PlacedNode> all() {
    const tinygltf::Model& model = asset_.model;
    if (!model.scenes.empty()) {
      add(model.scenes[static_cast<std::size_t>(std::max(model.defaultScene, 0))].nodes);
    } else {
      const std::vector<int> roots = nodes_without_parent(model);
      if (!roots.empty()) asset_.warn("the file has no scene; all its nodes are shown");
      add(roots);
    }
    return std::move(placed_);
  }

 private:
  struct Waiting {
    int node = 0, parent = -1, depth = 0;
    Transform to_parent;  ///< from the parent's space to the world
  };

  void add(const std::vector<int>& roots) {
    for (const int root : roots) {
      enter({.node = root, .parent = -1, .depth = 0, .to_parent = {}});
      // The last entered is left first: children are entered from the last to the first.
      while (!waiting_.empty()) {
        const Waiting next = waiting_.back();
        waiting_.pop_back();
        place(next);
      }
    }
  }

  void enter(const Waiting& waiting) {
    const auto index = static_cast<std::size_t>(waiting.node);
    if (seen_[index])
      asset_.fail(
          waiting.parent < 0 ? "/scenes" : fmt::format("/nodes/{}/children", waiting.parent),
          fmt::format("node {} is reached twice: a cycle, or a node with two parents",
                      waiting.node));
    if (waiting.depth > limits::gltf_node_depth)
      asset_.fail(fmt::format("/nodes/{}", waiting.node),
                  fmt::format("has more than {} nodes above it", limits::gltf_node_depth));
    seen_[index] = true;
    waiting_.push_back(waiting);
  }

  void place(const Waiting& waiting) {
    const tinygltf::Node& node = asset_.model.nodes[static_cast<std::size_t>(waiting.node)];
    const Transform to_world = waiting.to_parent * local_transform(node);
    placed_.push_back({waiting.node, to_world});
    for (auto child = node.children.rbegin(); child != node.children.rend(); ++child)
      enter({.node = *child,
             .parent = waiting.node,
             .depth = waiting.depth + 1,
             .to_parent = to_world});
  }

  Asset& asset_;
  std::vector<bool> seen_;
  std::vector<Waiting> waiting_;
  std::vector<PlacedNode> placed_;
};

}  // namespace

Transform local_transform(const tinygltf::Node& node) {
  Transform out;
  if (node.matrix.size() == 16) {
    for (std::size_t row = 0; row < 3; ++row)
      for (std::size_t column = 0; column < 4; ++column)
        out.m[row * 4 + column] = node.matrix[column * 4 + row];
    return out;
  }
  return transform_from(
      node.translation.size() == 3
          ? Vec3{node.translation[0], node.translation[1], node.translation[2]}
          : Vec3{0, 0, 0},
      node.rotation.size() == 4
          ? Quaternion{node.rotation[0], node.rotation[1], node.rotation[2], node.rotation[3]}
          : Quaternion{0, 0, 0, 1},
      node.scale.size() == 3 ? Vec3{node.scale[0], node.scale[1], node.scale[2]} : Vec3{1, 1, 1});
}

Transform transform_from(const Vec3& translation, const Quaternion& rotation, const Vec3& scale) {
  auto [x, y, z, w] = rotation;
  const double size = std::sqrt(x * x + y * y + z * z + w * w);
  if (size > 0) {
    x /= size, y /= size, z /= size, w /= size;
  } else {
    w = 1;
  }
  const std::array<double, 9> r{
      1 - 2 * (y * y + z * z), 2 * (x * y - z * w),     2 * (x * z + y * w),
      2 * (x * y + z * w),     1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
      2 * (x * z - y * w),     2 * (y * z + x * w),     1 - 2 * (x * x + y * y)};
  Transform out;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column)
      out.m[row * 4 + column] = r[row * 3 + column] * scale[column];
    out.m[row * 4 + 3] = translation[row];
  }
  return out;
}

std::vector<PlacedNode> placed_nodes(Asset& asset) { return Walk(asset).all(); }

}  // namespace tessera::scene::gltf
