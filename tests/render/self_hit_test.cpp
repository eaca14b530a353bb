#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "tests/render/support.hpp"
#include "worker/render/interaction.hpp"
#include "worker/render/octahedral.hpp"
#include "worker/render/warp.hpp"

/// A ray that leaves a surface, to either side, never meets it where it leaves: what is flat and
/// what is round from outside never again, what is round from inside at its far side.
namespace tessera::render::proof {
namespace {

constexpr float endless = std::numeric_limits<float>::infinity();

class Numbers {
 public:
  float next() { return static_cast<float>(generator_() >> 8U) * 0x1p-24F; }
  /// Uniform over all directions.
  Vec3 direction() {
    const float z = 2 * next() - 1, turn = 2 * pi * next();
    const float sine = std::sqrt(std::max(0.0F, 1 - z * z));
    return {sine * std::cos(turn), sine * std::sin(turn), z};
  }

 private:
  std::mt19937 generator_{7};
};

/// Flat things of every kind, spheres and ellipsoids, meshes that are flat or smooth, and an object
/// that is placed twice.
SceneMaker things(const scene::Transform& turn) {
  SceneMaker maker;
  const std::uint32_t white = maker.diffuse(1);
  maker.add(white, scene::Quad{{-2, -1.3, -2}, {4, 0, 0}, {0, 0.3, 4}}, turn);
  maker.add(white, scene::Disk{{0.9, 0.2, 0.4}, {1, 2, -1}, 0.7}, turn);
  maker.add(white, scene::Box{{-1.7, -1, -0.4}, {-0.9, 0.3, 0.6}}, turn);
  maker.add(white, scene::Sphere{{0.3, -0.4, -0.9}, 0.6}, turn);
  maker.add(white, scene::Sphere{{-0.4, 1, 0.2}, 0.5}, turn * scale(1, 0.4, 1.3));
  maker.add(white, ball(2, false), turn * translate(0.2, 0.9, 0.9) * scale(0.4, 0.3, 0.4));
  maker.add(white, ball(1, true), turn * translate(-1.2, 0.9, -0.9) * scale(0.5, 0.5, 0.5));
  maker.add(white, ball(3, true), turn * translate(1.1, 1.1, -0.3) * scale(0.4, 0.3, 0.4));
  scene::Shape part;
  part.geometry = ball(1, false);
  part.material = white;
  scene::Shape smooth_part = part;
  smooth_part.geometry = ball(2, true);
  smooth_part.to_world = translate(0, 0, 2.5);
  maker.description.objects = {{"twice", {part, smooth_part}}};
  maker.description.instances = {{0, turn * translate(1.4, -0.3, -0.6) * scale(0.3, 0.8, 0.3)},
                                 {0, turn * translate(-0.3, -0.8, 1.2) * scale(0.4, 0.1, 0.2)}};
  return maker;
}

/// A room that is a sphere, one that is an ellipsoid, one that is a smooth mesh.
std::array<SceneMaker, 3> rooms(const scene::Transform& turn) {
  std::array<SceneMaker, 3> makers;
  makers[0].add(makers[0].diffuse(1), scene::Sphere{{0, 0, 0}, 3}, turn);
  makers[1].add(makers[1].diffuse(1), scene::Sphere{{0, 0, 0}, 1}, turn * scale(4, 1.5, 2));
  makers[2].add(makers[2].diffuse(1), ball(2, true), turn * scale(4, 2, 3));
  return makers;
}

/// How rays left, and how many of those met at once what they had left.
struct Count {
  int out = 0;     ///< from what is flat, or round and left outwards
  int into = 0;    ///< … round and left inwards
  int raised = 0;  ///< … from over a smooth mesh's face
  int again = 0;
  int escaped = 0;  ///< of `into`, those that came out of a closed sphere without meeting it
};

/// How far along `out`, which leads from a sphere's hit into it, its far side is.
double chord(const Scene& scene, const accel::Hit& hit, const Vec3& out) {
  const accel::Affine& m = scene.placements[scene.placement_of(hit)].to_world;
  const auto column = [&](std::size_t i) {
    return Vec3d{double{m[i]}, double{m[i + 4]}, double{m[i + 8]}};
  };
  const Vec3d a = column(0), b = column(1), c = column(2), d = to_double(out);
  const Vec3d local =
      Vec3d{dot(d, cross(b, c)), dot(a, cross(d, c)), dot(a, cross(b, d))} / dot(a, cross(b, c));
  const Vec3d normal = normalize(Vec3d{double{hit.ng[0]}, double{hit.ng[1]}, double{hit.ng[2]}});
  const double radius = double{scene.geometry_of(hit).spheres[hit.primitive].radius};
  return -2 * radius * dot(normal, local) / dot(local, local);
}

/// The normal that a smooth mesh has at a hit, as long as it may be, before it is turned to whom it
/// is seen by (normal_map.hpp).
Vec3 own_normal(const Scene& scene, const accel::Hit& hit) {
  const Geometry& geometry = scene.geometry_of(hit);
  const std::array<float, 9>& m = scene.placements[scene.placement_of(hit)].normal_to_world;
  const std::array<float, 3> weights{1 - hit.u - hit.v, hit.u, hit.v};
  Vec3 n;
  for (std::size_t i = 0; i < 3; ++i)
    n += decode_octahedral(geometry.normals[geometry.triangles[hit.primitive][i]]) * weights[i];
  return {m[0] * n.x + m[1] * n.y + m[2] * n.z, m[3] * n.x + m[4] * n.y + m[5] * n.z,
          m[6] * n.x + m[7] * n.y + m[8] * n.z};
}

/// Sends a ray from `at`, which `ray` met by `hit`, along `out` as integrators do, and counts it.
void leave(const Scene& scene, const Ray& ray, const accel::Hit& hit, const Interaction& at,
           const Vec3& out, Count& count) {
  const ShadingPoint& point = at.shading;
  const float down = -dot(out, point.normal);
  const bool below = down * dot(point.wo, point.normal) > 0;
  const bool into = scene.geometry_of(hit).kind == GeometryKind::spheres && down > 0;
  const bool raised =
      point.rounded && below && dot(out, point.shading.n) * dot(point.wo, point.shading.n) > 0;
  Ray next = at.leave(out, endless, ray);
  if (raised && !leave_rounded(scene, at, next)) return;
  ++(raised ? count.raised : into ? count.into : count.out);
  // How far off it may meet the same surface again: a sphere at its far side; a face, from over it,
  // only where the normal was turned to the viewer, and the mesh's own does not have the ray over
  // it.
  double far = std::numeric_limits<double>::infinity();
  if (into) far = chord(scene, hit, out);
  if (raised && dot(out, own_normal(scene, hit)) * down <= 0)
    far = double{dot(next.origin - at.p, point.normal)} / double{down};
  const accel::Hit met = scene.intersect(next);
  const bool same = met.any() && met.geometry == hit.geometry && met.primitive == hit.primitive &&
                    met.instance == hit.instance;
  count.again += same && double{met.t} < 0.5 * far ? 1 : 0;
  count.escaped += into && !met.any() ? 1 : 0;
}

/// A direction to either side of what is hit at `at`, or one almost within the surface.
Vec3 away(Numbers& numbers, const Interaction& at, bool grazing) {
  const Vec3 out = numbers.direction();
  if (!grazing) return out;
  const float height = dot(out, at.shading.normal);
  return normalize(out - at.shading.normal * (height * (1 - 1e-4F)));
}

/// Sends rays from `reach` times `from` about `place` at what stands there and, from all that they
/// meet, rays to either side: one in two almost within the surface.
Count self_hits(const Scene& scene, const Vec3d& place, float reach, float from) {
  Numbers numbers;
  Count count;
  const Vec3 middle = to_float(place - Vec3d{scene.origin[0], scene.origin[1], scene.origin[2]});
  for (int i = 0; i < 20'000; ++i) {
    Ray ray;
    ray.origin = middle + numbers.direction() * (from * reach);
    ray.direction = normalize(middle + numbers.direction() * (0.6F * reach) - ray.origin);
    ray.t_max = endless;
    const accel::Hit hit = scene.intersect(ray);
    if (!hit.any()) continue;
    const Interaction at = surface_at(scene, ray, hit);
    for (int k = 0; k < 8; ++k) leave(scene, ray, hit, at, away(numbers, at, k % 2 == 0), count);
  }
  return count;
}

void expect_none(const SceneMaker& maker, const std::string& what, const Vec3d& place = {},
                 double size = 1) {
  const Count count = self_hits(maker.build(), place, static_cast<float>(3 * size), 1.5F);
  EXPECT_GT(count.out, 50'000) << what;
  EXPECT_GT(count.into, 4'000) << what;
  EXPECT_GT(count.raised, 500) << what;
  EXPECT_EQ(count.again, 0) << "of " << count.out << " + " << count.into << " + " << count.raised
                            << ", " << what;
}

TEST(SelfHit, ThereIsNoneAtAnySize) {
  for (const double factor : {1e-3, 0x1p-10, 1.0, 0x1p10, 1e3}) {
    SceneMaker maker = things({});
    maker.scaled(factor, {0, 0, 0});
    expect_none(maker, "scaled by " + std::to_string(factor), {}, factor);
  }
}

/// Something far off, so that no origin takes the place back.
SceneMaker with_something_opposite(SceneMaker maker, const Vec3d& place) {
  maker.add(maker.diffuse(0.5), scene::Sphere{{-place.x, -place.y, -place.z}, 1e-3});
  return maker;
}

TEST(SelfHit, ThereIsNoneHoweverItIsTurnedAndMoved) {
  for (const double degrees : {17.0, 45.0, 131.0})
    expect_none(things(rotate({1, 2, 0.5}, degrees)), "turned");
  for (const double away : {10.0, 1e3}) {
    const Vec3d place{away, -2 * away, 0.3 * away};
    const SceneMaker maker = things(translate(place.x, place.y, place.z) * rotate({3, 1, 1}, 64));
    expect_none(with_something_opposite(maker, place), "moved by " + std::to_string(away), place);
  }
}

/// Of a room that is round, out of which no ray gets either.
void expect_closed(const SceneMaker& maker, const std::string& what, const Vec3d& place = {},
                   double size = 1) {
  const Count count = self_hits(maker.build(), place, static_cast<float>(size), 1);
  EXPECT_GT(count.out, 50'000) << what;
  EXPECT_EQ(count.again, 0) << "of " << count.out << " + " << count.into << ", " << what;
  EXPECT_EQ(count.escaped, 0) << "of " << count.into << ", " << what;
}

TEST(SelfHit, ThereIsNoneFromInsideARoomThatIsRound) {
  for (SceneMaker& maker : rooms(rotate({1, 2, 0.5}, 31)))
    for (const double factor : {0x1p-10, 1.0, 1e3}) {
      SceneMaker scaled = maker;
      scaled.scaled(factor, {0, 0, 0});
      expect_closed(scaled, "scaled by " + std::to_string(factor), {}, factor);
    }
  for (const double away : {10.0, 1e3}) {
    const Vec3d place{away, -2 * away, 0.3 * away};
    for (SceneMaker& maker : rooms(translate(place.x, place.y, place.z) * rotate({3, 1, 1}, 64)))
      expect_closed(with_something_opposite(maker, place), "moved by " + std::to_string(away),
                    place);
  }
}

}  // namespace
}  // namespace tessera::render::proof
