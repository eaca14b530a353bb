#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "common/scene/description.hpp"
#include "worker/accel/accel.hpp"
#include "worker/accel/buffer.hpp"
#include "worker/render/bsdf/material.hpp"
#include "worker/render/identity.hpp"
#include "worker/render/lights/environment_map.hpp"
#include "worker/render/lights/light_table.hpp"
#include "worker/render/ray.hpp"
#include "worker/render/surface_detail.hpp"
#include "worker/render/textures/texture_table.hpp"
#include "worker/render/vec.hpp"

/// A scene in the form that renders. worker/scene makes it from a description; nothing here changes
/// while it renders.
namespace tessera::render {

/// What a ray is there for, as a bit of its mask and of those of what it may meet
/// (scene::Visibility).
namespace ray_mask {
inline constexpr accel::Mask camera = 1, shadow = 2, indirect = 4;
}

enum class GeometryKind : std::uint8_t { triangles, quads, spheres };

/// Where the faces of an object begin.
struct ObjectFaces {
  std::uint32_t first = 0;
  std::uint32_t object = no_id;  ///< which of Scene::object_identities
};

/// Primitives of one kind, merged. Their buffers are those that Embree reads.
struct Geometry {
  GeometryKind kind = GeometryKind::triangles;
  scene::Visibility visibility;  ///< where its group's placement does not hide more
  bool round = false;  ///< of each quad only the ellipse is there that touches it from within
  accel::Buffer<accel::Point> positions;
  accel::Buffer<accel::Triangle> triangles;
  accel::Buffer<accel::Quad> quads;
  accel::Buffer<accel::Sphere> spheres;
  accel::LargeVector<std::uint32_t> normals;    ///< octahedral, one per position; empty: flat
  accel::LargeVector<std::uint16_t> materials;  ///< one per face
  /// Per face: which emitter of its group it is, counted from 0, or no_id; empty where no face
  /// emits.
  accel::LargeVector<std::uint32_t> emitters;
  /// What its materials want and it has (detail_flag); 0: hits are not asked for details.
  std::uint8_t details = 0;
  std::array<accel::LargeVector<Vec2>, 2> uvs;  ///< sets 0 and 1; one per position, or empty
  accel::LargeVector<std::uint32_t> tangents;   ///< encode_tangent's, one per position, or empty
  /// Set 0 where no material wants it, so that it is not among `uvs`: for the AOV alone, where the
  /// scene keeps it. Or empty.
  accel::LargeVector<Vec2> spare_uvs;
  /// Linear R, G, B, A as shares of 65535, one per position, or empty.
  accel::LargeVector<std::array<std::uint16_t, 4>> colors;
  std::vector<ObjectFaces> objects;  ///< ascending, from face 0 on

  [[nodiscard]] std::size_t faces() const { return materials.size(); }
  /// Some of its faces emit.
  [[nodiscard]] bool emits() const { return !emitters.empty(); }
  [[nodiscard]] std::size_t bytes() const;
};

/// Geometries that are placed as one: the world itself, or what instances share.
struct Group {
  std::vector<Geometry> geometries;  ///< numbered as accel numbers them
};

/// How a group stands in the world. Placement 0 is the world's own, and the identity; placement 1 +
/// k is instance k.
struct Placement {
  std::uint32_t group = 0;
  /// Emitter e of the group is light first_light + e; no_id: they are left to paths to find.
  std::uint32_t first_light = 0;
  std::uint32_t object = no_id;  ///< which object all of it is; no_id: as its geometries say
  bool moved = false;            ///< false: the identity
  scene::Visibility visibility;
  accel::Affine to_world{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  std::array<float, 9> normal_to_world{1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< inverse transpose, rows
  /// How much the way into the group's space and back enlarges rounding errors, ≥ 1.
  float error_scale = 1;

  [[nodiscard]] Vec3 point_to_world(const Vec3& p) const {
    const accel::Affine& m = to_world;
    return {m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3],
            m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
            m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]};
  }
  /// How large the numbers are from which points of a face come to stand in the world: of those of
  /// the group's space, `e` along each axis, and of the way there and back.
  [[nodiscard]] Vec3 extent_to_world(const Vec3& e) const {
    const accel::Affine& m = to_world;
    const auto row = [&](std::size_t i) {
      return (std::abs(m[i]) * e.x + std::abs(m[i + 1]) * e.y + std::abs(m[i + 2]) * e.z +
              std::abs(m[i + 3])) *
             error_scale;
    };
    return {row(0), row(4), row(8)};
  }
};

/// What AOVs look at and pictures do not: a scene keeps it only if it is built for a job that asks.
struct SceneNeeds {
  bool coordinates = false;  ///< texture coordinates that no material wants
  bool operator==(const SceneNeeds&) const = default;
  /// True if what is kept for these is enough for `other`.
  [[nodiscard]] bool cover(const SceneNeeds& other) const {
    return coordinates || !other.coordinates;
  }
};

struct Scene {
  explicit Scene(const accel::Device& on) : device(on), accel(on) {}

  accel::Device device;
  SceneNeeds keeps;
  std::vector<Group> groups;          ///< 0 is the world's
  std::vector<Placement> placements;  ///< 0 is the world's
  std::vector<CompiledMaterial> materials;
  TextureTable textures;
  std::shared_ptr<const EnvironmentMap> environment_map;  ///< the environment's picture, if any
  LightTable lights;
  std::vector<std::string> light_groups;  ///< names, by Light::group
  std::vector<Identity> object_identities, material_identities;
  /// How far before a light's sampled point a shadow ray must end, so that the light does not hide
  /// itself: its rounding error.
  std::vector<float> light_errors;
  std::vector<accel::Scene> group_accels;  ///< of groups 1, 2, …
  accel::Scene accel;
  std::uint32_t world_geometries = 0;  ///< accel's geometries from here on are instances
  /// What was subtracted, in double, from all positions: float is finest near 0.
  std::array<double, 3> origin{};
  Bounds3 bounds;
  bool has_gaps = false;  ///< some surface may be not there, as its opacity says or from behind
  bool moving = false;    ///< some position or transform has more than one time key
  std::vector<scene::Camera> cameras;

  /// True if the scene has an environment, be it black: then a ray that leaves the scene sees
  /// something.
  bool has_environment = false;
  /// The camera sees nothing that is infinitely far.
  bool film_transparent = false;
  bool has_holes = false;     ///< some surface is a holdout or a shadow catcher
  bool has_catchers = false;  ///< … the latter
  /// What scattered rays meet is not what hides lights from surfaces: some surface is seen by one
  /// of the two alone, or some that emits not by both. What a scattered ray runs into then does not
  /// say what light it brings (found_light.hpp).
  bool lit_apart = false;

  /// Where a hit's geometry stands in `placements`, and the geometry.
  [[nodiscard]] std::uint32_t placement_of(const accel::Hit& hit) const {
    return hit.instance == accel::none ? 0 : 1 + hit.instance - world_geometries;
  }
  [[nodiscard]] const Geometry& geometry_of(const accel::Hit& hit) const {
    return groups[placements[placement_of(hit)].group].geometries[hit.geometry];
  }

  /// The object that a hit is on.
  [[nodiscard]] Identity object_of(const accel::Hit& hit) const;

  [[nodiscard]] scene::Visibility visibility_of(std::uint32_t placement,
                                                std::uint32_t geometry) const {
    const Placement& placed = placements[placement];
    return placed.visibility & groups[placed.group].geometries[geometry].visibility;
  }

  [[nodiscard]] accel::Hit intersect(const Ray& ray, accel::Mask mask = accel::everything) const {
    return accel.intersect(to_accel(ray), mask);
  }
  /// By what shadow rays meet.
  [[nodiscard]] bool occluded(const Ray& ray) const {
    return accel.occluded(to_accel(ray), ray_mask::shadow);
  }

  static accel::Ray to_accel(const Ray& ray) {
    return {{ray.origin.x, ray.origin.y, ray.origin.z},
            ray.t_min,
            {ray.direction.x, ray.direction.y, ray.direction.z},
            ray.time,
            ray.t_max};
  }
};

}  // namespace tessera::render
