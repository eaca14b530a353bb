#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/job/job_spec.hpp"

/// A scene as a person wrote it, parsed and checked, before anything renders. Right-handed, y up by
/// convention, metres unless the file's author thinks otherwise; colours are linear Rec.709.
/// Everything is a plain value.
namespace tessera::scene {

using Vec3 = std::array<double, 3>;
using Vec2 = std::array<double, 2>;
using Color = std::array<double, 3>;

/// Affine, row-major 3×4: p' = M·(p, 1).
struct Transform {
  std::array<double, 12> m{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  bool operator==(const Transform&) const = default;
};
/// a after b: p' = a(b(p)).
Transform operator*(const Transform& a, const Transform& b);
/// The factor by which lengths grow, if it is the same in all directions.
std::optional<double> uniform_scale(const Transform& t);
/// True if the linear part maps space to something flat, or to numbers that cannot be computed
/// with.
bool is_singular(const Transform& t);

// ---- materials ----
/// Lambertian reflection, one-sided emission none; both sides scatter.
struct Diffuse {
  Color reflectance{0.5, 0.5, 0.5};  ///< 0…1
};
/// Perfect specular reflection.
struct Mirror {
  Color reflectance{1, 1, 1};  ///< 0…1
};
/// Smooth interface between air and a dielectric; the shape must be closed for refraction to make
/// sense.
struct Dielectric {
  double ior = 1.5;              ///< inside over outside, > 0
  Color transmittance{1, 1, 1};  ///< multiplies what passes the interface, 0…1
  Color reflectance{1, 1, 1};    ///< multiplies what is reflected, 0…1
};
/// Emits, and may scatter as a diffuse surface besides.
struct Emitter {
  Color radiance{1, 1, 1};     ///< W·sr⁻¹·m⁻², ≥ 0
  bool two_sided = false;      ///< else it emits only on the side of the geometric normal
  Color reflectance{0, 0, 0};  ///< Lambertian, on both sides, 0…1
};
struct Material {
  std::string name;
  std::variant<Diffuse, Mirror, Dielectric, Emitter> surface;
};

// ---- shapes, each in its own space ----
/// Parallelogram: corner + s·edge_u + t·edge_v, s, t in 0…1; the normal is along edge_u × edge_v.
/// Edges need not be at right angles.
struct Quad {
  Vec3 corner{}, edge_u{1, 0, 0}, edge_v{0, 1, 0};
};
/// The normal points outwards.
struct Sphere {
  Vec3 center{};
  double radius = 1;
};
/// Axis-aligned between two corners; normals point outwards.
struct Box {
  Vec3 low{0, 0, 0}, high{1, 1, 1};
};
/// Triangles, counter-clockwise from outside. Counts are those of vertices; normals and uvs are
/// empty or as many.
struct Mesh {
  std::vector<std::array<float, 3>> positions;
  std::vector<std::array<float, 3>> normals;
  std::vector<std::array<float, 2>> uvs;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};
struct Shape {
  std::string name;  ///< for errors and later for ids
  std::variant<Quad, Sphere, Box, Mesh> geometry;
  std::uint32_t material = 0;  ///< index into Scene::materials
  Transform to_world;          ///< or to its object's space, where it stands in an object
};

/// Shapes that are placed as one, any number of times.
struct Object {
  std::string name;
  std::vector<Shape> shapes;
};
struct Instance {
  std::uint32_t object = 0;  ///< index into Scene::objects
  Transform to_world;
};

// ---- camera, environment ----
/// Perspective. Looks from `eye` to `target`; x of the film runs to the right, y down.
struct Camera {
  std::string name;
  Vec3 eye{0, 0, 5}, target{0, 0, 0}, up{0, 1, 0};
  double fov_y_degrees = 40;  ///< from the film's lower to its upper edge; 0…180, exclusive
};
struct Environment {
  Color radiance{0, 0, 0};  ///< constant, from every direction
};

struct Scene {
  std::string name;
  std::vector<Camera> cameras;  ///< at least one
  std::optional<Environment> environment;
  std::vector<Material> materials;
  std::vector<Shape> shapes;  ///< placed once, in the world
  std::vector<Object> objects;
  std::vector<Instance> instances;
  RenderSettings render;  ///< what the scene file asks for; a command line may override it
};

}  // namespace tessera::scene
