#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/job/job_spec.hpp"
#include "common/scene/material.hpp"
#include "common/scene/name_list.hpp"
#include "common/scene/texture.hpp"

/// A scene as a person wrote it, parsed and checked, before anything renders. Right-handed, y up by
/// convention, metres unless the file's author thinks otherwise; colours are linear Rec.709.
/// Everything is a plain value.
namespace tessera::scene {

using Vec3 = std::array<double, 3>;
using Vec2 = std::array<double, 2>;

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

/// Which rays meet a shape, and what the camera makes of it.
struct Visibility {
  bool camera = true;    ///< rays that have not scattered since they left the camera
  bool shadow = true;    ///< rays that ask whether a light reaches a surface
  bool indirect = true;  ///< rays that have scattered
  bool holdout = false;  ///< where the camera sees it, the picture has a hole
  /// As a holdout, but the shadows that fall on it are in the picture's alpha. Not both.
  bool shadow_catcher = false;
  bool operator==(const Visibility&) const = default;
};
/// Of a shape in what is placed: neither shows what the other hides.
Visibility operator&(const Visibility& a, const Visibility& b);

// ---- shapes, each in its own space ----
/// Parallelogram: corner + s·edge_u + t·edge_v, s, t in 0…1; the normal is along edge_u × edge_v.
/// Edges need not be at right angles.
struct Quad {
  Vec3 corner{}, edge_u{1, 0, 0}, edge_v{0, 1, 0};
};
/// A circle and what is within it; a transform may make an ellipse of it.
struct Disk {
  Vec3 center{};
  Vec3 normal{0, 0, 1};  ///< of any length but 0
  double radius = 1;
};
/// The square that a disk touches from within, on the same side: its edge_u is horizontal, to the
/// right of who sees the front upright.
Quad square_around(const Disk& disk);
/// The normal points outwards.
struct Sphere {
  Vec3 center{};
  double radius = 1;
};
/// Axis-aligned between two corners; normals point outwards.
struct Box {
  Vec3 low{0, 0, 0}, high{1, 1, 1};
};
/// Triangles, counter-clockwise from outside. Counts are those of vertices; all but positions are
/// empty or as many.
/// How many of each a mesh has.
struct MeshSize {
  std::uint64_t positions = 0, normals = 0;
  std::uint64_t uvs = 0, uvs1 = 0;
  std::uint64_t tangents = 0, colors = 0, triangles = 0;
};
struct Mesh {
  std::vector<std::array<float, 3>> positions;
  std::vector<std::array<float, 3>> normals;
  std::vector<std::array<float, 2>> uvs;   ///< set 0; (0, 0) is a picture's upper left, v runs down
  std::vector<std::array<float, 2>> uvs1;  ///< set 1
  /// Unit, with the bitangent's sign as fourth: bitangent = cross(normal, tangent)·w. Empty: made
  /// from uvs 0 where a normal map wants them.
  std::vector<std::array<float, 4>> tangents;
  std::vector<std::array<float, 4>> colors;  ///< linear R, G, B, A
  std::vector<std::array<std::uint32_t, 3>> triangles;
  /// What it had, where only the corners of its box were kept, as positions: see survey_scene().
  std::optional<MeshSize> outlined;
};
struct Shape {
  std::string name;  ///< for errors, ids and mattes
  std::variant<Quad, Disk, Sphere, Box, Mesh> geometry;
  std::uint32_t material = 0;  ///< index into Scene::materials
  Transform to_world;          ///< or to its object's space, where it stands in an object
  Visibility visibility = {};  ///< with its object's
};

/// Shapes that are placed as one, any number of times.
struct Object {
  std::string name;
  std::vector<Shape> shapes;
};
struct Instance {
  std::uint32_t object = 0;  ///< index into Scene::objects
  Transform to_world;
  Visibility visibility = {};           ///< with that of each of its shapes
  std::uint32_t name = NameList::none;  ///< in Scene::instance_names; none: its object's
};

// ---- camera, environment ----
/// How a camera's rays run.
enum class Projection {
  perspective,
  orthographic,     ///< alongside each other
  equirectangular,  ///< in all directions: the whole sphere, longitude along x, latitude along y
};
/// A thin lens: what lies in the plane of focus is sharp.
struct Lens {
  double radius = 0;            ///< of the aperture, ≥ 0; 0 is a pinhole
  double focus_distance = 1;    ///< of the plane of focus from the eye's plane, > 0
  int blades = 0;               ///< corners of the aperture, on its radius; 0: round
  double rotation_degrees = 0;  ///< of the first corner from the right, towards what is up
};
/// Looks from `eye` to `target`; x of the film runs to the right, y down.
struct Camera {
  std::string name;
  Vec3 eye{0, 0, 5}, target{0, 0, 0}, up{0, 1, 0};
  Projection projection = Projection::perspective;
  double fov_y_degrees = 40;  ///< perspective: between the film's lower and upper edge; 0…180
  double orthographic_height = 0;  ///< orthographic: what the film's height shows; > 0
  Lens lens;                       ///< not of equirectangular cameras
  /// Perspective and orthographic: how far the picture's middle lies from the line of sight, to the
  /// right in film widths, upwards in film heights. What is parallel to the film stays so.
  Vec2 shift{0, 0};
  /// A film narrower than this, width over height, shows more above and below, and as much at its
  /// sides as one of this shape.
  double least_aspect = 0;
};
/// Light from infinitely far. Of a direction of unit length (x, y, z) the picture shows the point
/// u = ½ − atan2(−z, x)/2π from its left and v = acos(y)/π from its top: its middle is seen along
/// +x, and +z lies to the right of it.
struct Environment {
  Color radiance{0, 0, 0};  ///< from every direction; multiplies the picture's where there is one
  std::optional<std::uint32_t> image;  ///< index into Scene::images
  double strength = 1;                 ///< multiplies all of it
  double rotation_degrees = 0;   ///< of the surroundings about +y, counter-clockwise from above
  std::string light_group = {};  ///< empty: the default group
};

// ---- lights without a size, which nothing runs into ----
/// Radiates alike in all directions: irradiance = intensity / distance² at a surface that faces it.
struct PointLight {
  Vec3 position{};
  Color intensity{1, 1, 1};  ///< W·sr⁻¹, ≥ 0
};
/// A point light that shines into a cone: full within the inner angle; from there to the outer, by
/// the square of where the angle's cosine lies between theirs.
struct SpotLight {
  Vec3 position{};
  Vec3 direction{0, 0, -1};  ///< in which it shines; of any length but 0
  Color intensity{1, 1, 1};  ///< along its axis, W·sr⁻¹, ≥ 0
  double inner_degrees = 0;  ///< from the axis, 0 ≤ inner < outer ≤ 90
  double outer_degrees = 45;
};
/// Shines from infinitely far in one direction, or, if it has an angle, from a disk of even
/// radiance about it, which rays run into.
struct DirectionalLight {
  Vec3 direction{0, -1, 0};   ///< in which it shines; of any length but 0
  Color irradiance{1, 1, 1};  ///< of a surface that faces it, W·m⁻², ≥ 0
  double angle_degrees = 0;   ///< the disk's diameter, 0 or 0.001…180
};
struct PunctualLight {
  std::string name;
  std::variant<PointLight, SpotLight, DirectionalLight> shape;
  std::string light_group = {};  ///< empty: the default group
};

struct Scene {
  std::string name;
  std::vector<Camera> cameras;  ///< at least one
  std::optional<Environment> environment;
  std::vector<PunctualLight> lights;
  std::vector<Image> images;
  std::vector<Texture> textures;
  std::vector<Material> materials;
  std::vector<Shape> shapes;  ///< placed once, in the world
  std::vector<Object> objects;
  std::vector<Instance> instances;
  NameList instance_names;
  /// The camera does not see what is infinitely far: the picture is transparent there.
  bool film_transparent = false;
  RenderSettings render;  ///< what the scene file asks for; a command line may override it
};

}  // namespace tessera::scene
