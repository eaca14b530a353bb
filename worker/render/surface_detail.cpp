#include "worker/render/surface_detail.hpp"

#include <cmath>

#include "worker/render/fastmath.hpp"
#include "worker/render/octahedral.hpp"
#include "worker/render/scene.hpp"

namespace tessera::render {
namespace {

/// Beyond this slant the footprint grows no longer.
constexpr float cosine_least = 1e-3F;

Vec2 operator+(Vec2 a, Vec2 b) { return {a.x + b.x, a.y + b.y}; }
Vec2 operator-(Vec2 a, Vec2 b) { return {a.x - b.x, a.y - b.y}; }
Vec2 operator*(Vec2 a, float s) { return {a.x * s, a.y * s}; }

/// The flat triangle of vertices that a hit is in, and its weights in it.
struct Corners {
  std::array<std::uint32_t, 3> vertex;
  std::array<float, 3> weight;
};

Corners corners_of(const Geometry& geometry, const accel::Hit& hit) {
  if (geometry.kind == GeometryKind::triangles) {
    const accel::Triangle& face = geometry.triangles[hit.primitive];
    return {{face[0], face[1], face[2]}, {1 - hit.u - hit.v, hit.u, hit.v}};
  }
  const accel::Quad& face = geometry.quads[hit.primitive];
  if (hit.u + hit.v <= 1) {
    return {{face[0], face[1], face[3]}, {1 - hit.u - hit.v, hit.u, hit.v}};
  }
  return {{face[2], face[3], face[1]}, {hit.u + hit.v - 1, 1 - hit.u, 1 - hit.v}};
}

/// A surface about a hit: two steps along it, in the world, and what they change.
struct Patch {
  Vec3d step1, step2;
  std::array<Vec2, 2> uv, uv1, uv2;  ///< of both sets: at the hit, changes by the steps
};

Vec3d step_in_world(const Placement& placement, const Vec3& v) {
  const accel::Affine& m = placement.to_world;
  if (!placement.moved) return to_double(v);
  return to_double(Vec3{m[0] * v.x + m[1] * v.y + m[2] * v.z, m[4] * v.x + m[5] * v.y + m[6] * v.z,
                        m[8] * v.x + m[9] * v.y + m[10] * v.z});
}

Vec3 vec(const accel::Point& p) { return {p[0], p[1], p[2]}; }

Vec2 sphere_uv(const Vec3& n) {
  return {0.5F + fast::atan2(n.x, n.z) * (0.5F * inv_pi), fast::acos(n.y) * inv_pi};
}

Patch sphere_patch(const Geometry& geometry, const Placement& placement, const accel::Hit& hit) {
  const Vec3 n = normalize(Vec3{hit.ng[0], hit.ng[1], hit.ng[2]});
  const float radius = geometry.spheres[hit.primitive].radius;
  const float rim = std::max(std::sqrt(n.x * n.x + n.z * n.z), 1e-6F);
  Patch patch;
  patch.step1 = step_in_world(placement, Vec3{n.z / rim, 0, -n.x / rim} * radius);
  patch.step2 = step_in_world(placement, Vec3{n.y * n.x / rim, -rim, n.y * n.z / rim} * radius);
  for (std::size_t set = 0; set < 2; ++set) {
    patch.uv[set] = sphere_uv(n);
    patch.uv1[set] = {0.5F * inv_pi / rim, 0};
    patch.uv2[set] = {0, inv_pi};
  }
  return patch;
}

Patch flat_patch(const Geometry& geometry, const Placement& placement, const Corners& corners) {
  const auto point = [&](std::size_t i) { return vec(geometry.positions[corners.vertex[i]]); };
  Patch patch;
  patch.step1 = step_in_world(placement, point(1) - point(0));
  patch.step2 = step_in_world(placement, point(2) - point(0));
  for (std::size_t set = 0; set < 2; ++set) {
    const auto& uvs = geometry.uvs[set];
    if (uvs.empty()) {
      if (set == 1) {
        patch.uv[1] = patch.uv[0];
        patch.uv1[1] = patch.uv1[0];
        patch.uv2[1] = patch.uv2[0];
      }
      continue;
    }
    const Vec2 a = uvs[corners.vertex[0]], b = uvs[corners.vertex[1]], c = uvs[corners.vertex[2]];
    patch.uv[set] = a * corners.weight[0] + b * corners.weight[1] + c * corners.weight[2];
    patch.uv1[set] = b - a;
    patch.uv2[set] = c - a;
  }
  return patch;
}

/// What a way along the surface changes: it is written as a sum of the patch's steps. In double, as
/// the fourth power of a small triangle's edge leaves float's range.
class Differential {
 public:
  explicit Differential(const Patch& patch)
      : patch_(patch),
        g11_(length_squared(patch.step1)),
        g12_(dot(patch.step1, patch.step2)),
        g22_(length_squared(patch.step2)) {
    const double determinant = g11_ * g22_ - g12_ * g12_;
    inverse_ = determinant > 0 ? 1 / determinant : 0;
  }
  [[nodiscard]] std::array<Vec2, 2> along(const Vec3& way) const {
    const double d1 = dot(patch_.step1, to_double(way)), d2 = dot(patch_.step2, to_double(way));
    const auto w1 = static_cast<float>((g22_ * d1 - g12_ * d2) * inverse_);
    const auto w2 = static_cast<float>((g11_ * d2 - g12_ * d1) * inverse_);
    return {patch_.uv1[0] * w1 + patch_.uv2[0] * w2, patch_.uv1[1] * w1 + patch_.uv2[1] * w2};
  }

 private:
  const Patch& patch_;
  double g11_, g12_, g22_, inverse_;
};

void add_footprint(const Patch& patch, const ConeCut& cut, SurfaceDetail& out) {
  if (!(cut.width > 0)) return;
  const float cosine = dot(cut.direction, cut.normal);
  Vec3 slant = normalize(cut.direction - cut.normal * cosine);
  if (slant == Vec3{}) slant = Frame(cut.normal).s;
  const Differential differential(patch);
  const auto across = differential.along(cross(cut.normal, slant) * cut.width);
  const auto along =
      differential.along(slant * (cut.width / std::max(std::abs(cosine), cosine_least)));
  for (std::size_t set = 0; set < 2; ++set) {
    out.uv[set].across = across[set];
    out.uv[set].along = along[set];
  }
}

/// 0 where no corner has one.
Vec3 interpolated_tangent(const Geometry& geometry, const Placement& placement,
                          const Corners& corners, float& sign) {
  Vec3 sum;
  float turned = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::uint32_t code = geometry.tangents[corners.vertex[i]];
    if (code == no_tangent) continue;
    sum += decode_octahedral(code & ~1U) * corners.weight[i];
    turned += (code & 1U) != 0 ? -corners.weight[i] : corners.weight[i];
  }
  sign = turned < 0 ? -1.0F : 1.0F;
  if (placement.moved) {
    const accel::Affine& m = placement.to_world;
    const Vec3 x{m[0], m[1], m[2]}, y{m[4], m[5], m[6]}, z{m[8], m[9], m[10]};
    if (dot(cross(x, y), z) < 0) sign = -sign;
  }
  return to_float(step_in_world(placement, sum));
}

/// The direction in which u of a set grows and v stays, and whether the picture is mirrored.
Vec3 patch_tangent(const Patch& patch, std::size_t set, const Vec3& n, float& sign) {
  const Vec2 a = patch.uv1[set], b = patch.uv2[set];
  const double area = double{a.x} * b.y - double{a.y} * b.x;
  const double turn = area < 0 ? -1 : 1;
  const Vec3d u = (patch.step1 * double{b.y} - patch.step2 * double{a.y}) * turn;
  const Vec3d v = (patch.step2 * double{a.x} - patch.step1 * double{b.x}) * turn;
  sign = dot(cross(to_double(n), u), v) > 0 ? -1.0F : 1.0F;
  return area == 0 ? Vec3{} : to_float(normalize(u));
}

/// `tangent` laid into the plane of n; any direction in it where that leaves nothing.
Vec3 laid_about(const Vec3& n, const Vec3& tangent) {
  const Vec3 t = normalize(tangent - n * dot(n, tangent));
  return t == Vec3{} || !is_finite(t) ? Frame(n).s : t;
}

void add_tangents(const Geometry& geometry, const Placement& placement, const Corners& corners,
                  const Patch& patch, const Vec3& n, SurfaceDetail& out) {
  float sign = 1;
  Vec3 tangent;
  if (!geometry.tangents.empty())
    tangent = interpolated_tangent(geometry, placement, corners, sign);
  if (tangent == Vec3{}) tangent = patch_tangent(patch, tangent_set(geometry.details), n, sign);
  out.tangent = laid_about(n, tangent);
  out.bitangent = cross(n, out.tangent) * sign;
  const Differential differential(patch);
  const auto by_tangent = differential.along(out.tangent);
  const auto by_bitangent = differential.along(out.bitangent);
  for (std::size_t set = 0; set < 2; ++set) {
    out.uv[set].by_tangent = by_tangent[set];
    out.uv[set].by_bitangent = by_bitangent[set];
  }
}

void add_color(const Geometry& geometry, const Corners& corners, SurfaceDetail& out) {
  std::array<float, 4> sum{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& color = geometry.colors[corners.vertex[i]];
    for (std::size_t c = 0; c < 4; ++c) sum[c] += static_cast<float>(color[c]) * corners.weight[i];
  }
  constexpr float unit = 1.0F / 65535;
  out.color = {sum[0] * unit, sum[1] * unit, sum[2] * unit};
  out.alpha = sum[3] * unit;
}

}  // namespace

SurfaceDetail detail_at(const Geometry& geometry, const Placement& placement, const accel::Hit& hit,
                        const ConeCut& cut) {
  SurfaceDetail out;
  out.has = geometry.details;
  const bool sphere = geometry.kind == GeometryKind::spheres;
  const Corners corners = sphere ? Corners{} : corners_of(geometry, hit);
  if ((geometry.details & (detail_flag::uv0 | detail_flag::uv1 | detail_flag::tangent)) != 0) {
    const Patch patch =
        sphere ? sphere_patch(geometry, placement, hit) : flat_patch(geometry, placement, corners);
    for (std::size_t set = 0; set < 2; ++set) out.uv[set].uv = patch.uv[set];
    add_footprint(patch, cut, out);
    if (out.has_tangents()) {
      add_tangents(geometry, placement, corners, patch, cut.shading, out);
    }
  }
  if (!geometry.colors.empty()) add_color(geometry, corners, out);
  return out;
}

Frame SurfaceDetail::tangents_about(const Vec3& n) const {
  if (!has_tangents()) return Frame(n);
  const Vec3 s = laid_about(n, tangent), t = cross(n, s);
  return Frame(s, dot(t, bitangent) < 0 ? -t : t, n);
}

namespace {
Vec2 interpolated_uv(const Geometry& geometry, const accel::Hit& hit,
                     const accel::LargeVector<Vec2>& uvs) {
  if (geometry.kind == GeometryKind::spheres) {
    return sphere_uv(normalize(Vec3{hit.ng[0], hit.ng[1], hit.ng[2]}));
  }
  if (uvs.empty()) return {};
  const Corners corners = corners_of(geometry, hit);
  return uvs[corners.vertex[0]] * corners.weight[0] + uvs[corners.vertex[1]] * corners.weight[1] +
         uvs[corners.vertex[2]] * corners.weight[2];
}
}  // namespace

Vec2 uv_at(const Geometry& geometry, const accel::Hit& hit, std::uint8_t uv_set) {
  const std::size_t set = uv_set == 1 && !geometry.uvs[1].empty() ? 1 : 0;
  return interpolated_uv(geometry, hit, geometry.uvs[set]);
}

Vec2 surface_uv(const Geometry& geometry, const accel::Hit& hit) {
  const bool wanted = !geometry.uvs[0].empty();
  return interpolated_uv(geometry, hit, wanted ? geometry.uvs[0] : geometry.spare_uvs);
}

float vertex_alpha_at(const Geometry& geometry, const accel::Hit& hit) {
  if (geometry.colors.empty()) return 1;
  const Corners corners = corners_of(geometry, hit);
  float sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    sum += static_cast<float>(geometry.colors[corners.vertex[i]][3]) * corners.weight[i];
  }
  return sum * (1.0F / 65535);
}

std::uint32_t encode_tangent(const Vec3& unit, bool negative) {
  if (unit == Vec3{}) return no_tangent;
  return (encode_octahedral(unit) & ~1U) | (negative ? 1U : 0U);
}

}  // namespace tessera::render
