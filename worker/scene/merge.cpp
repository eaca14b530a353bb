#include "worker/scene/merge.hpp"

#include <cmath>

#include "worker/render/octahedral.hpp"
#include "worker/scene/affine.hpp"
#include "worker/scene/details.hpp"
#include "worker/scene/parallelogram.hpp"
#include "worker/scene/radiance.hpp"

namespace tessera::worker {
namespace {

using render::Geometry;
using render::GeometryKind;
using render::Vec3d;

/// Embree addresses vertices by 32 bits of 4 bytes; a geometry of more than this many goes on in a
/// second one.
constexpr std::size_t vertices_most = std::size_t{1} << 28;

struct Size {
  std::size_t faces = 0, vertices = 0;
};

Size size_of(const scene::Shape& shape) {
  if (std::holds_alternative<scene::Quad>(shape.geometry)) return {1, 4};
  if (std::holds_alternative<scene::Disk>(shape.geometry)) return {1, 4};
  if (std::holds_alternative<scene::Box>(shape.geometry)) return {6, 24};
  if (std::holds_alternative<scene::Sphere>(shape.geometry)) return {1, 0};
  const auto& mesh = std::get<scene::Mesh>(shape.geometry);
  return {mesh.triangles.size(), mesh.positions.size()};
}

/// Shapes that become one geometry.
struct Bin {
  GeometryKind kind = GeometryKind::triangles;
  bool smooth = false;
  bool round = false;
  bool emits = false;
  bool tangents = false;
  bool coordinates = false;  ///< some of its shapes have texture coordinates of set 0
  std::uint8_t details = 0;
  scene::Visibility visibility;
  Size size;
  std::vector<const PlacedShape*> shapes;
};

Bin bin_for(const scene::Shape& shape, std::span<const render::CompiledMaterial> materials) {
  Bin bin;
  bin.emits = materials[shape.material].emits();
  bin.details = details_of(shape, materials[shape.material].wants);
  bin.tangents = has_vertex_tangents(shape, bin.details);
  if (const auto* mesh = std::get_if<scene::Mesh>(&shape.geometry)) {
    bin.smooth = !mesh->normals.empty();
  } else {
    bin.kind = std::holds_alternative<scene::Sphere>(shape.geometry) ? GeometryKind::spheres
                                                                     : GeometryKind::quads;
    bin.round = std::holds_alternative<scene::Disk>(shape.geometry);
  }
  return bin;
}

std::vector<Bin> sort_into_bins(std::span<const PlacedShape> shapes,
                                std::span<const render::CompiledMaterial> materials) {
  std::vector<Bin> bins;
  for (const PlacedShape& placed : shapes) {
    const Size size = size_of(*placed.shape);
    if (size.faces == 0) continue;
    Bin wanted = bin_for(*placed.shape, materials);
    wanted.visibility = placed.visibility;
    Bin* found = nullptr;
    for (Bin& bin : bins) {
      const bool alike = bin.kind == wanted.kind && bin.smooth == wanted.smooth &&
                         bin.round == wanted.round && bin.emits == wanted.emits &&
                         bin.details == wanted.details && bin.tangents == wanted.tangents &&
                         bin.visibility == wanted.visibility;
      if (alike && bin.size.vertices + size.vertices <= vertices_most) found = &bin;
    }
    if (found == nullptr) found = &bins.emplace_back(std::move(wanted));
    found->shapes.push_back(&placed);
    found->coordinates = found->coordinates || has_coordinates(*placed.shape);
    found->size.faces += size.faces;
    found->size.vertices += size.vertices;
  }
  return bins;
}

accel::Point rounded_point(const Vec3d& p) {
  return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
}

/// Fills one geometry, shape after shape.
class Filler {
 public:
  Filler(const Bin& bin, const std::array<double, 3>& origin, bool all_coordinates)
      : origin_(origin) {
    geometry_.kind = bin.kind;
    geometry_.round = bin.round;
    geometry_.visibility = bin.visibility;
    geometry_.materials.resize(bin.size.faces);
    geometry_.positions = accel::Buffer<accel::Point>(bin.size.vertices);
    if (bin.kind == GeometryKind::triangles) {
      geometry_.triangles = accel::Buffer<accel::Triangle>(bin.size.faces);
      if (bin.smooth) geometry_.normals.resize(bin.size.vertices);
    } else if (bin.kind == GeometryKind::quads) {
      geometry_.quads = accel::Buffer<accel::Quad>(bin.size.faces);
    } else {
      geometry_.spheres = accel::Buffer<accel::Sphere>(bin.size.faces);
    }
    make_room(geometry_, bin.details, bin.tangents, bin.size.vertices);
    if (all_coordinates && bin.coordinates && geometry_.uvs[0].empty())
      geometry_.spare_uvs.resize(bin.size.vertices);
    for (const PlacedShape* placed : bin.shapes) add(*placed);
  }

  Geometry take() { return std::move(geometry_); }

 private:
  void add(const PlacedShape& placed) {
    auto& objects = geometry_.objects;
    if (objects.empty() || objects.back().object != placed.object)
      objects.push_back({static_cast<std::uint32_t>(face_), placed.object});
    material_ = static_cast<std::uint16_t>(placed.shape->material);
    to_group_ = relative_to(placed.to_group, origin_);
    mirrored_ = determinant(linear(to_group_)) < 0;
    auto& shape = placed.shape->geometry;
    if (const auto* quad = std::get_if<scene::Quad>(&shape)) {
      add_quad(*quad);
    } else if (const auto* disk = std::get_if<scene::Disk>(&shape)) {
      add_quad(square_around(*disk));
    } else if (const auto* box = std::get_if<scene::Box>(&shape)) {
      add_box(*box);
    } else if (const auto* sphere = std::get_if<scene::Sphere>(&shape)) {
      add_sphere(*sphere);
    } else if (auto* mesh = std::get_if<scene::Mesh>(&shape)) {
      add_mesh(*mesh);
      *mesh = scene::Mesh{};
    }
  }

  std::uint32_t add_point(const Vec3d& p) {
    geometry_.positions[vertex_] = rounded_point(times_point(to_group_, p));
    return vertex_++;
  }

  void add_quad(const scene::Quad& quad) {
    add_quad(render::to_vec3d(quad.corner), render::to_vec3d(quad.edge_u),
             render::to_vec3d(quad.edge_v), quad_uvs());
  }

  void add_quad(const Vec3d& corner, const Vec3d& u, const Vec3d& v, const FaceUvs& uvs) {
    const std::uint32_t a = add_point(corner), b = add_point(corner + u),
                        c = add_point(corner + u + v), d = add_point(corner + v);
    auto& kept = geometry_.uvs[0].empty() ? geometry_.spare_uvs : geometry_.uvs[0];
    if (!kept.empty()) {
      for (std::uint32_t i = 0; i < 4; ++i) kept[a + i] = uvs[i];
    }
    // What mirrors turns corners around; the outer side stays the outer side.
    geometry_.quads[face_] = mirrored_ ? accel::Quad{a, d, c, b} : accel::Quad{a, b, c, d};
    geometry_.materials[face_++] = material_;
  }

  void add_box(const scene::Box& box) {
    const Vec3d low = render::to_vec3d(box.low), high = render::to_vec3d(box.high);
    const Vec3d x{high.x - low.x, 0, 0}, y{0, high.y - low.y, 0}, z{0, 0, high.z - low.z};
    const std::array<FaceUvs, 6>& uvs = box_uvs();
    add_quad(low, z, y, uvs[0]);
    add_quad(low, x, z, uvs[1]);
    add_quad(low, y, x, uvs[2]);
    add_quad(low + x, y, z, uvs[3]);
    add_quad(low + y, z, x, uvs[4]);
    add_quad(low + z, x, y, uvs[5]);
  }

  void add_sphere(const scene::Sphere& sphere) {
    const double scale = uniform_scale(to_group_).value_or(1);
    geometry_.spheres[face_] = {
        rounded_point(times_point(to_group_, render::to_vec3d(sphere.center))),
        static_cast<float>(sphere.radius * scale)};
    geometry_.materials[face_++] = material_;
  }

  void add_mesh(const scene::Mesh& mesh) {
    const std::uint32_t first = vertex_;
    for (const auto& p : mesh.positions) add_point({p[0], p[1], p[2]});
    if (!mesh.normals.empty()) {
      const Matrix3 back = inverse(linear(to_group_)).value_or(Matrix3{1, 0, 0, 0, 1, 0, 0, 0, 1});
      for (std::size_t i = 0; i < mesh.normals.size(); ++i) {
        const auto& n = mesh.normals[i];
        const Vec3d turned = times_transposed(back, {n[0], n[1], n[2]});
        geometry_.normals[first + i] =
            render::encode_octahedral(render::to_float(render::normalize(turned)));
      }
    }
    add_mesh_details(mesh, first, to_group_, geometry_);
    for (const auto& t : mesh.triangles) {
      const accel::Triangle face{first + t[0], first + t[1], first + t[2]};
      geometry_.triangles[face_] = mirrored_ ? accel::Triangle{face[0], face[2], face[1]} : face;
      geometry_.materials[face_++] = material_;
    }
  }

  Geometry geometry_;
  std::array<double, 3> origin_;
  scene::Transform to_group_;
  std::uint16_t material_ = 0;
  bool mirrored_ = false;
  std::uint32_t vertex_ = 0;
  std::size_t face_ = 0;
};

bool shines_as_one_with_next(const Geometry& geometry, std::uint32_t face,
                             const std::array<double, 3>& origin,
                             std::span<const render::CompiledMaterial> materials) {
  return geometry.kind == GeometryKind::triangles && face + 1 < geometry.faces() &&
         geometry.materials[face] == geometry.materials[face + 1] &&
         !materials[geometry.materials[face]].radiance_varies &&
         parallelogram(geometry, face, origin).has_value();
}

}  // namespace

MergedGroup merge(std::span<const PlacedShape> shapes,
                  std::span<const render::CompiledMaterial> materials,
                  const render::TextureTable& textures, const std::array<double, 3>& origin,
                  bool all_coordinates) {
  for (const PlacedShape& placed : shapes) {
    const std::uint8_t wants = materials[placed.shape->material].wants;
    part_for_tangents(*placed.shape, details_of(*placed.shape, wants));
  }
  MergedGroup out;
  out.origin = origin;
  for (const Bin& bin : sort_into_bins(shapes, materials)) {
    Geometry geometry = Filler(bin, origin, all_coordinates).take();
    if (bin.emits) {
      const auto number = static_cast<std::uint32_t>(out.group.geometries.size());
      const std::vector<render::Color> radiances = mean_radiances(geometry, materials, textures);
      geometry.emitters.resize(geometry.faces());
      for (std::uint32_t face = 0; face < geometry.faces(); ++face) {
        if (render::is_black(radiances[face])) {
          geometry.emitters[face] = render::no_id;
          continue;
        }
        const auto emitter = static_cast<std::uint32_t>(out.emitters.size());
        const bool with_next = shines_as_one_with_next(geometry, face, origin, materials);
        out.emitters.push_back({number, face, radiances[face], with_next});
        geometry.emitters[face] = emitter;
        if (with_next) geometry.emitters[++face] = emitter;
      }
    }
    out.group.geometries.push_back(std::move(geometry));
  }
  return out;
}

}  // namespace tessera::worker
