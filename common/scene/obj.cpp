#define TINYOBJLOADER_IMPLEMENTATION
#include "common/scene/obj.hpp"

#include <fmt/format.h>
#include <tiny_obj_loader.h>

#include <cmath>
#include <istream>
#include <streambuf>
#include <unordered_map>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "common/base/names.hpp"
#include "common/scene/read_file.hpp"

namespace tessera::scene {

namespace {

/// A stream over bytes that stand in memory, without a copy.
class ViewBuffer : public std::streambuf {
 public:
  explicit ViewBuffer(std::string_view text) {
    char* const first = const_cast<char*>(text.data());  // the get area is only read
    setg(first, first, first + text.size());
  }
};

/// Which vertex each (position, normal, texture coordinate) became.
struct CornerHash {
  std::size_t operator()(const std::array<int, 3>& key) const noexcept {
    std::uint64_t value = static_cast<std::uint32_t>(key[0]);
    value = value * 0x9e3779b97f4a7c15ULL + static_cast<std::uint32_t>(key[1]);
    value = value * 0x9e3779b97f4a7c15ULL + static_cast<std::uint32_t>(key[2]);
    return static_cast<std::size_t>(value ^ (value >> 31));
  }
};

std::array<float, 3> triple(const std::vector<float>& values, int index) {
  const std::size_t at = static_cast<std::size_t>(index) * 3;
  return {values[at], values[at + 1], values[at + 2]};
}

/// The unit normal of a triangle; zero if it has none.
std::array<float, 3> plane_normal(const std::array<std::array<float, 3>, 3>& p) {
  std::array<double, 3> u{}, v{};
  for (std::size_t i = 0; i < 3; ++i) {
    u[i] = static_cast<double>(p[1][i]) - p[0][i];
    v[i] = static_cast<double>(p[2][i]) - p[0][i];
  }
  const std::array<double, 3> n{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                                u[0] * v[1] - u[1] * v[0]};
  const double size = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  if (!(size > 0)) return {0, 0, 0};
  return {static_cast<float>(n[0] / size), static_cast<float>(n[1] / size),
          static_cast<float>(n[2] / size)};
}

/// Puts the faces of the library's shapes into one mesh with one index a vertex.
class Joiner {
 public:
  Joiner(const tinyobj::attrib_t& attributes, const std::vector<tinyobj::shape_t>& shapes,
         const ObjCounts& counts)
      : attributes_(attributes), shapes_(shapes) {
    mesh_.triangles.reserve(counts.triangles);
    for (const tinyobj::shape_t& shape : shapes)
      for (const tinyobj::index_t& corner : shape.mesh.indices) {
        normals_ = normals_ || corner.normal_index >= 0;
        uvs_ = uvs_ || corner.texcoord_index >= 0;
      }
  }

  Mesh join() {
    if (!normals_ && !uvs_) return positions_alone();
    const std::size_t expected = attributes_.vertices.size() / 3;
    mesh_.positions.reserve(expected);
    index_.reserve(expected);
    for (const tinyobj::shape_t& shape : shapes_)
      for (std::size_t i = 0; i + 2 < shape.mesh.indices.size(); i += 3)
        triangle(&shape.mesh.indices[i]);
    return std::move(mesh_);
  }

 private:
  Mesh positions_alone() {
    mesh_.positions.resize(attributes_.vertices.size() / 3);
    for (std::size_t i = 0; i < mesh_.positions.size(); ++i)
      mesh_.positions[i] = triple(attributes_.vertices, static_cast<int>(i));
    for (const tinyobj::shape_t& shape : shapes_)
      for (std::size_t i = 0; i + 2 < shape.mesh.indices.size(); i += 3) {
        auto& out = mesh_.triangles.emplace_back();
        for (std::size_t k = 0; k < 3; ++k)
          out[k] = static_cast<std::uint32_t>(shape.mesh.indices[i + k].vertex_index);
      }
    return std::move(mesh_);
  }

  /// Some programs write 0 0 0 where they know no normal.
  [[nodiscard]] bool has_normal(const tinyobj::index_t& corner) const {
    return corner.normal_index >= 0 &&
           triple(attributes_.normals, corner.normal_index) != std::array<float, 3>{};
  }

  /// A face that lacks a corner's normal is flat: it gets its plane's at all three.
  void triangle(const tinyobj::index_t* corners) {
    std::array<float, 3> flat{};
    bool whole = true;
    for (std::size_t k = 0; k < 3; ++k) whole = whole && has_normal(corners[k]);
    if (normals_ && !whole)
      flat = plane_normal({triple(attributes_.vertices, corners[0].vertex_index),
                           triple(attributes_.vertices, corners[1].vertex_index),
                           triple(attributes_.vertices, corners[2].vertex_index)});
    auto& out = mesh_.triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k)
      out[k] = whole || !normals_ ? shared(corners[k]) : append(corners[k], &flat);
  }

  std::uint32_t shared(const tinyobj::index_t& corner) {
    const std::array<int, 3> key{corner.vertex_index, corner.normal_index, corner.texcoord_index};
    const auto [found, fresh] =
        index_.try_emplace(key, static_cast<std::uint32_t>(mesh_.positions.size()));
    if (fresh) append(corner, nullptr);
    return found->second;
  }

  /// A new vertex; `normal` stands in for the corner's own.
  std::uint32_t append(const tinyobj::index_t& corner, const std::array<float, 3>* normal) {
    mesh_.positions.push_back(triple(attributes_.vertices, corner.vertex_index));
    if (normals_)
      mesh_.normals.push_back(normal != nullptr ? *normal
                                                : triple(attributes_.normals, corner.normal_index));
    if (uvs_) {
      const std::size_t at = static_cast<std::size_t>(std::max(corner.texcoord_index, 0)) * 2;
      const bool there = corner.texcoord_index >= 0;
      // OBJ's v runs up from a picture's lower left, the description's down from its upper left.
      mesh_.uvs.push_back(
          {there ? attributes_.texcoords[at] : 0, there ? 1 - attributes_.texcoords[at + 1] : 0});
    }
    return static_cast<std::uint32_t>(mesh_.positions.size() - 1);
  }

  const tinyobj::attrib_t& attributes_;
  const std::vector<tinyobj::shape_t>& shapes_;
  bool normals_ = false, uvs_ = false;
  Mesh mesh_;
  std::unordered_map<std::array<int, 3>, std::uint32_t, CornerHash> index_;
};

}  // namespace

Mesh parse_obj(std::string_view text, const std::string& name) {
  const ObjCounts counts = check_obj(text, name);
  ViewBuffer buffer(text);
  std::istream stream(&buffer);
  tinyobj::attrib_t attributes;
  std::vector<tinyobj::shape_t> shapes;
  std::vector<tinyobj::material_t> materials;
  std::string warnings, errors;
  const bool good = tinyobj::LoadObj(&attributes, &shapes, &materials, &warnings, &errors, &stream,
                                     nullptr, true, false);
  const auto refuse = [&](const std::string& message) {
    throw Error(ErrorKind::bad_input, message, {.file = name, .key = {}});
  };
  if (!good) refuse(fmt::format("not a good OBJ file: {}", excerpt(errors, 200)));
  if (attributes.vertices.size() != counts.positions * 3)
    refuse(fmt::format("{} positions were read, and {} stand in it", attributes.vertices.size() / 3,
                       counts.positions));
  Mesh mesh = Joiner(attributes, shapes, counts).join();
  if (mesh.triangles.empty()) refuse("has no face with an area");
  return mesh;
}

Mesh read_obj(const std::filesystem::path& file, const std::string& name) {
  const std::string text = read_file(file, name, limits::mesh_file_bytes);
  return parse_obj(text, name);
}

}  // namespace tessera::scene
