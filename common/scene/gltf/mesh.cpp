#include "common/scene/gltf/mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/limits.hpp"
#include "common/scene/fields.hpp"

namespace tessera::scene::gltf {

namespace {

using Triangle = std::array<std::uint32_t, 3>;

/// The corners in the order in which they make triangles, by the primitive's mode.
std::vector<Triangle> triangles_of(int mode, const std::vector<std::array<std::uint32_t, 1>>& at) {
  std::vector<Triangle> out;
  const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
    const Triangle t{at[a][0], at[b][0], at[c][0]};
    // Strips join their parts by triangles without an area.
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) out.push_back(t);
  };
  const std::size_t count = at.size();
  if (mode == TINYGLTF_MODE_TRIANGLES) {
    out.reserve(count / 3);
    for (std::size_t i = 0; i + 2 < count; i += 3) add(i, i + 1, i + 2);
  } else if (mode == TINYGLTF_MODE_TRIANGLE_STRIP) {
    for (std::size_t i = 0; i + 2 < count; ++i) add(i, i + 1 + i % 2, i + 2 - i % 2);
  } else {
    for (std::size_t i = 1; i + 1 < count; ++i) add(i, i + 1, 0);
  }
  return out;
}

class PrimitiveReader {
 public:
  PrimitiveReader(const Asset& asset, Accessors& accessors, const tinygltf::Primitive& primitive,
                  const Pose& pose, const std::string& place)
      : asset_(asset), accessors_(accessors), primitive_(primitive), pose_(pose), place_(place) {}

  PosedMesh read() {
    const bool unpacked = accessors_.unpack_mesh(primitive_, place_);
    mesh_.positions =
        accessors_.vectors<3>(primitive_.attributes.at("POSITION"), attribute_place("POSITION"));
    check_positions();
    mesh_.triangles =
        triangles_of(unpacked ? TINYGLTF_MODE_TRIANGLES : primitive_.mode, read_corners());
    if (mesh_.triangles.empty()) return {};
    read_attributes();
    morph(asset_, accessors_, primitive_, pose_, place_, mesh_);
    const bool in_world = skin(asset_, accessors_, primitive_, pose_, place_, mesh_);
    if (in_world) check_positions();
    drop_unused();
    mend_normals();
    return {.mesh = std::move(mesh_), .in_world = in_world};
  }

 private:
  [[nodiscard]] std::string attribute_place(std::string_view key) const {
    return fmt::format("{}/attributes/{}", place_, key);
  }

  void check_positions() {
    for (std::size_t i = 0; i < mesh_.positions.size(); ++i)
      for (const float x : mesh_.positions[i])
        if (!(std::abs(static_cast<double>(x)) <= length_most))
          asset_.fail(attribute_place("POSITION"),
                      fmt::format("vertex {} is {} away; {} is the most", i, x, length_most));
  }

  std::vector<std::array<std::uint32_t, 1>> read_corners() {
    if (primitive_.indices < 0) {
      std::vector<std::array<std::uint32_t, 1>> out(mesh_.positions.size());
      for (std::uint32_t i = 0; i < out.size(); ++i) out[i][0] = i;
      return out;
    }
    auto out = accessors_.integers<1>(primitive_.indices, place_ + "/indices");
    for (std::size_t i = 0; i < out.size(); ++i)
      if (out[i][0] >= mesh_.positions.size())
        asset_.fail(place_ + "/indices", fmt::format("index {} names vertex {}; the last is {}", i,
                                                     out[i][0], mesh_.positions.size() - 1));
    return out;
  }

  /// The accessor of an attribute, or −1; as many elements as there are positions.
  int find(const std::string& key) {
    const auto found = primitive_.attributes.find(key);
    if (found == primitive_.attributes.end()) return -1;
    const std::size_t count = accessors_.count(found->second);
    if (count != mesh_.positions.size())
      asset_.fail(attribute_place(key), fmt::format("has {} elements, and POSITION has {}", count,
                                                    mesh_.positions.size()));
    return found->second;
  }

  void read_attributes() {
    if (const int normals = find("NORMAL"); normals >= 0) {
      mesh_.normals = accessors_.vectors<3>(normals, attribute_place("NORMAL"));
      // Tangents say nothing where normals are lacking (glTF 2.0, 3.7.2.1).
      if (const int tangents = find("TANGENT"); tangents >= 0)
        mesh_.tangents = accessors_.vectors<4>(tangents, attribute_place("TANGENT"));
    }
    if (const int uvs = find("TEXCOORD_0"); uvs >= 0)
      mesh_.uvs = accessors_.vectors<2>(uvs, attribute_place("TEXCOORD_0"));
    if (const int uvs = find("TEXCOORD_1"); uvs >= 0)
      mesh_.uvs1 = accessors_.vectors<2>(uvs, attribute_place("TEXCOORD_1"));
    if (const int colors = find("COLOR_0"); colors >= 0) read_colors(colors);
  }

  void read_colors(int accessor) {
    const std::string place = attribute_place("COLOR_0");
    if (accessors_.components(accessor) == 4) {
      mesh_.colors = accessors_.vectors<4>(accessor, place);
    } else {
      for (const auto& c : accessors_.vectors<3>(accessor, place))
        mesh_.colors.push_back({c[0], c[1], c[2], 1});
    }
    for (auto& color : mesh_.colors)
      for (float& x : color) x = std::clamp(x, 0.0F, 1.0F);
  }

  /// Primitives often share their vertices with others and use a few of them.
  void drop_unused() {
    if (mesh_.triangles.size() * 3 >= mesh_.positions.size()) return;
    constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> fresh(mesh_.positions.size(), none), kept;
    for (Triangle& t : mesh_.triangles)
      for (std::uint32_t& corner : t) {
        if (fresh[corner] == none) {
          fresh[corner] = static_cast<std::uint32_t>(kept.size());
          kept.push_back(corner);
        }
        corner = fresh[corner];
      }
    const auto keep = [&](auto& values) {
      if (values.empty()) return;
      std::remove_reference_t<decltype(values)> out;
      out.reserve(kept.size());
      for (const std::uint32_t index : kept) out.push_back(values[index]);
      values = std::move(out);
    };
    keep(mesh_.positions);
    keep(mesh_.normals);
    keep(mesh_.uvs);
    keep(mesh_.uvs1);
    keep(mesh_.tangents);
    keep(mesh_.colors);
  }

  /// A normal without a length becomes that of a face which uses it.
  void mend_normals() {
    constexpr float least = 1e-15F;
    const auto bad = [&](const std::array<float, 3>& n) {
      return !(std::max({std::abs(n[0]), std::abs(n[1]), std::abs(n[2])}) > least);
    };
    if (std::none_of(mesh_.normals.begin(), mesh_.normals.end(), bad)) return;
    for (const Triangle& t : mesh_.triangles)
      for (const std::uint32_t corner : t)
        if (bad(mesh_.normals[corner])) mesh_.normals[corner] = face_normal(t);
    for (auto& normal : mesh_.normals)
      if (bad(normal)) normal = {0, 0, 1};
  }

  [[nodiscard]] std::array<float, 3> face_normal(const Triangle& t) const {
    std::array<double, 3> u{}, v{};
    for (std::size_t i = 0; i < 3; ++i) {
      const double at = mesh_.positions[t[0]][i];
      u[i] = mesh_.positions[t[1]][i] - at;
      v[i] = mesh_.positions[t[2]][i] - at;
    }
    const std::array<double, 3> n{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                                  u[0] * v[1] - u[1] * v[0]};
    const double size = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (!(size > 0)) return {};
    return {static_cast<float>(n[0] / size), static_cast<float>(n[1] / size),
            static_cast<float>(n[2] / size)};
  }

  const Asset& asset_;
  Accessors& accessors_;
  const tinygltf::Primitive& primitive_;
  const Pose& pose_;
  const std::string& place_;
  Mesh mesh_;
};

template <class... Lists>
std::uint64_t bytes_of(const Lists&... lists) {
  return (std::uint64_t{0} + ... + (lists.size() * sizeof(typename Lists::value_type)));
}

std::uint64_t bytes_of(const Mesh& mesh) {
  return bytes_of(mesh.positions, mesh.normals, mesh.uvs, mesh.uvs1, mesh.tangents, mesh.colors,
                  mesh.triangles);
}

}  // namespace

std::optional<PosedMesh> read_primitive(Asset& asset, Accessors& accessors,
                                        const tinygltf::Primitive& primitive, const Pose& pose,
                                        const std::string& place) {
  if (primitive.mode < TINYGLTF_MODE_TRIANGLES) {
    asset.warn("points and lines have no area, and are passed over");
    return std::nullopt;
  }
  if (!primitive.attributes.contains("POSITION")) {
    asset.warn(place + " has no positions, and is passed over");
    return std::nullopt;
  }
  const std::uint64_t before = accessors.budget();
  PosedMesh out = PrimitiveReader(asset, accessors, primitive, pose, place).read();
  accessors.keep_only(before, bytes_of(out.mesh), place);
  if (!out.mesh.triangles.empty()) return out;
  asset.warn(place + " has no triangle with an area, and is passed over");
  return std::nullopt;
}

}  // namespace tessera::scene::gltf
