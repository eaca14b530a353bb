#include "common/scene/gltf/pose.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tessera::scene::gltf {

namespace {

/// Adds weight · delta to the first three numbers of each.
template <std::size_t Size>
void add(std::vector<std::array<float, Size>>& to, const std::vector<std::array<float, 3>>& deltas,
         double weight) {
  for (std::size_t i = 0; i < to.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      to[i][k] = static_cast<float>(static_cast<double>(to[i][k]) +
                                    weight * static_cast<double>(deltas[i][k]));
}

/// Sums of joints, by their weights, for each vertex.
class Blend {
 public:
  explicit Blend(std::size_t vertices) : sums_(vertices, Transform{{}}) {}

  void add(std::size_t vertex, const Transform& joint, double weight) {
    for (std::size_t i = 0; i < 12; ++i) sums_[vertex].m[i] += weight * joint.m[i];
  }
  [[nodiscard]] const Transform& operator[](std::size_t vertex) const { return sums_[vertex]; }

 private:
  std::vector<Transform> sums_;
};

std::array<float, 3> moved(const Transform& t, const std::array<float, 3>& p) {
  std::array<float, 3> out{};
  for (std::size_t i = 0; i < 3; ++i)
    out[i] = static_cast<float>(t.m[4 * i] * static_cast<double>(p[0]) +
                                t.m[4 * i + 1] * static_cast<double>(p[1]) +
                                t.m[4 * i + 2] * static_cast<double>(p[2]) + t.m[4 * i + 3]);
  return out;
}

std::array<float, 3> unit(const Vec3& v) {
  const double size = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  if (!(size > 0)) return {};
  return {static_cast<float>(v[0] / size), static_cast<float>(v[1] / size),
          static_cast<float>(v[2] / size)};
}

/// Of the linear part.
std::array<double, 9> cofactors_of(const Transform& t) {
  const auto& m = t.m;
  return {m[5] * m[10] - m[6] * m[9], m[6] * m[8] - m[4] * m[10], m[4] * m[9] - m[5] * m[8],
          m[2] * m[9] - m[1] * m[10], m[0] * m[10] - m[2] * m[8], m[1] * m[8] - m[0] * m[9],
          m[1] * m[6] - m[2] * m[5],  m[2] * m[4] - m[0] * m[6],  m[0] * m[5] - m[1] * m[4]};
}

bool mirrors(const Transform& t) {
  const std::array<double, 9> cofactors = cofactors_of(t);
  return t.m[0] * cofactors[0] + t.m[1] * cofactors[1] + t.m[2] * cofactors[2] < 0;
}

/// By the cofactors: the inverse's transpose up to a factor, and there also where the matrix has no
/// inverse.
std::array<float, 3> turned_normal(const Transform& t, const std::array<float, 3>& n) {
  const std::array<double, 9> cofactors = cofactors_of(t);
  const double sign = mirrors(t) ? -1 : 1;
  Vec3 out{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < 3; ++k)
      out[i] += sign * cofactors[3 * i + k] * static_cast<double>(n[k]);
  return unit(out);
}

std::array<float, 4> turned_tangent(const Transform& t, const std::array<float, 4>& tangent) {
  Vec3 out{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < 3; ++k) out[i] += t.m[4 * i + k] * static_cast<double>(tangent[k]);
  const auto direction = unit(out);
  return {direction[0], direction[1], direction[2], mirrors(t) ? -tangent[3] : tangent[3]};
}

/// What mirrors turns corners around; the outer side stays the outer side. A face between what is
/// mirrored and what is not goes with most of its corners.
void keep_outside(const std::vector<bool>& mirrored, Mesh& mesh) {
  for (auto& corners : mesh.triangles) {
    const auto turned = std::count_if(corners.begin(), corners.end(),
                                      [&](std::uint32_t corner) { return mirrored[corner]; });
    if (turned >= 2) std::swap(corners[1], corners[2]);
  }
}

}  // namespace

Pose pose_of(const Asset& asset, Accessors& accessors, int node,
             const std::vector<const Transform*>& worlds) {
  const tinygltf::Node& from = asset.model.nodes[static_cast<std::size_t>(node)];
  Pose out;
  out.weights = !from.weights.empty()
                    ? from.weights
                    : asset.model.meshes[static_cast<std::size_t>(from.mesh)].weights;
  if (from.skin < 0) return out;
  const tinygltf::Skin& skin = asset.model.skins[static_cast<std::size_t>(from.skin)];
  const std::string place = fmt::format("/skins/{}", from.skin);
  std::vector<std::array<float, 16>> inverses;
  if (skin.inverseBindMatrices >= 0) {
    inverses = accessors.vectors<16>(skin.inverseBindMatrices, place + "/inverseBindMatrices");
    if (inverses.size() < skin.joints.size())
      asset.fail(place + "/inverseBindMatrices",
                 fmt::format("{} matrices for {} joints", inverses.size(), skin.joints.size()));
  }
  for (std::size_t i = 0; i < skin.joints.size(); ++i) {
    const Transform* world = worlds[static_cast<std::size_t>(skin.joints[i])];
    if (world == nullptr)
      asset.fail(fmt::format("{}/joints/{}", place, i), "is no node of the scene that is shown");
    Transform inverse;
    if (!inverses.empty())
      for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t column = 0; column < 4; ++column)
          inverse.m[row * 4 + column] = static_cast<double>(inverses[i][column * 4 + row]);
    out.joints.push_back(*world * inverse);
  }
  return out;
}

void morph(const Asset& asset, Accessors& accessors, const tinygltf::Primitive& primitive,
           const Pose& pose, const std::string& place, Mesh& mesh) {
  const std::size_t count = std::min(primitive.targets.size(), pose.weights.size());
  for (std::size_t i = 0; i < count; ++i) {
    if (pose.weights[i] == 0) continue;
    const auto apply = [&](const std::string& key, auto& values) {
      const auto found = primitive.targets[i].find(key);
      if (found == primitive.targets[i].end() || values.empty()) return;
      const std::string at = fmt::format("{}/targets/{}/{}", place, i, key);
      const auto deltas = accessors.vectors<3>(found->second, at);
      if (deltas.size() != values.size())
        asset.fail(
            at, fmt::format("has {} elements, and POSITION has {}", deltas.size(), values.size()));
      add(values, deltas, pose.weights[i]);
    };
    apply("POSITION", mesh.positions);
    apply("NORMAL", mesh.normals);
    apply("TANGENT", mesh.tangents);
  }
}

bool skin(const Asset& asset, Accessors& accessors, const tinygltf::Primitive& primitive,
          const Pose& pose, const std::string& place, Mesh& mesh) {
  if (pose.joints.empty() || !primitive.attributes.contains("JOINTS_0")) return false;
  const std::size_t count = mesh.positions.size();
  Blend blend(count);
  std::vector<double> totals(count, 0);
  for (int set = 0;; ++set) {
    const auto joints = primitive.attributes.find(fmt::format("JOINTS_{}", set));
    const auto weights = primitive.attributes.find(fmt::format("WEIGHTS_{}", set));
    if (joints == primitive.attributes.end() || weights == primitive.attributes.end()) break;
    const std::string at = fmt::format("{}/attributes/JOINTS_{}", place, set);
    const auto of = accessors.integers<4>(joints->second, at);
    const auto parts =
        accessors.vectors<4>(weights->second, fmt::format("{}/attributes/WEIGHTS_{}", place, set));
    if (of.size() != count || parts.size() != count)
      asset.fail(at, fmt::format("has {} elements, its weights {}, and POSITION has {}", of.size(),
                                 parts.size(), count));
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t k = 0; k < 4; ++k) {
        if (parts[i][k] == 0) continue;
        if (of[i][k] >= pose.joints.size())
          asset.fail(at, fmt::format("vertex {} names joint {}; the last is {}", i, of[i][k],
                                     pose.joints.size() - 1));
        blend.add(i, pose.joints[of[i][k]], static_cast<double>(parts[i][k]));
        totals[i] += static_cast<double>(parts[i][k]);
      }
  }
  std::vector<bool> mirrored(count);
  for (std::size_t i = 0; i < count; ++i) {
    Transform t = blend[i];
    // Weights that were rounded do not sum to 1; a vertex without any follows the first joint.
    if (totals[i] > 0)
      for (double& x : t.m) x /= totals[i];
    else
      t = pose.joints[0];
    mirrored[i] = mirrors(t);
    mesh.positions[i] = moved(t, mesh.positions[i]);
    if (!mesh.normals.empty()) mesh.normals[i] = turned_normal(t, mesh.normals[i]);
    if (!mesh.tangents.empty()) mesh.tangents[i] = turned_tangent(t, mesh.tangents[i]);
  }
  keep_outside(mirrored, mesh);
  return true;
}

}  // namespace tessera::scene::gltf
