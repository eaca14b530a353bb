#include <algorithm>
#include <cassert>
#include <cmath>

#include "worker/render/lights/plane.hpp"
#include "worker/render/lights/shapes.hpp"
#include "worker/render/lights/spherical_rectangle.hpp"
#include "worker/render/lights/spherical_triangle.hpp"
#include "worker/render/warp.hpp"

namespace tessera::render {

namespace {

// Below these solid angles a flat light is sampled by area: the spherical formulas run out of
// digits, and the light is so small or so nearly edge-on that it makes little odds.
constexpr double least_rectangle_angle = 1e-6;
constexpr double least_triangle_angle = 3e-5;
/// Cosine between edges below which a parallelogram is a rectangle: what rounding leaves of a right
/// angle in float.
constexpr double right_angle = 4e-6;

ShapeSample along(const Plane& plane, const Vec3d& wi, double pdf) {
  const double distance = plane.distance_along(wi);
  if (!std::isfinite(distance) || distance <= 0) return {};
  return {.wi = wi, .distance = distance, .pdf = pdf};
}

/// How far the highest point of a parallelogram stands over the lit surface of normal n.
template <class N>
N highest_of(const Vector3<N>& corner, const Vector3<N>& u, const Vector3<N>& v,
             const Vector3<N>& n) {
  return dot(corner, n) + greater(dot(u, n), N(0.0)) + greater(dot(v, n), N(0.0));
}
/// Something of it can light the surface, which may have no normal.
bool stands_over(double highest, const Vec3& surface) { return highest > 0 || surface == Vec3{}; }

/// A quad seen from the lit point.
struct SeenQuad {
  const QuadLight& light;
  Vec3d corner, u, v;
  Plane plane;

  SeenQuad(const QuadLight& quad, const Vec3& p)
      : light(quad),
        corner(to_double(quad.corner) - to_double(p)),
        u(to_double(quad.edge_u)),
        v(to_double(quad.edge_v)),
        plane(corner, u, v) {}

  /// False too if all of it is behind the lit surface, which scatters none of its light then.
  [[nodiscard]] bool visible(bool two_sided, const Vec3& surface) const {
    return sees(two_sided, plane.below) &&
           stands_over(highest_of(corner, u, v, to_double(surface)), surface);
  }
  [[nodiscard]] SphericalRectangle rectangle() const {
    return {corner, u, v, light.inverse_length_u, light.inverse_length_v};
  }
  /// The halves of a parallelogram, along the diagonal between its edges' ends.
  [[nodiscard]] SphericalTriangle near_half() const { return {corner, corner + u, corner + v}; }
  [[nodiscard]] SphericalTriangle far_half() const {
    return {corner + u + v, corner + v, corner + u};
  }
};

}  // namespace

QuadLight::QuadLight(const Vec3& corner_, const Vec3& edge_u_, const Vec3& edge_v_)
    : corner(corner_), edge_u(edge_u_), edge_v(edge_v_) {
  const Vec3d u = to_double(edge_u), v = to_double(edge_v);
  inverse_length_u = 1 / length(u);
  inverse_length_v = 1 / length(v);
  const double cosine = dot(u, v) * inverse_length_u * inverse_length_v;
  rectangle = std::abs(cosine) <= right_angle;
}

ShapeSample sample_shape(const QuadLight& light, bool two_sided, const LightContext& context,
                         Vec2 uv) {
  const SeenQuad quad(light, context.p);
  if (!quad.visible(two_sided, context.n)) return {};
  const double s = uv.x, t = uv.y;
  if (light.rectangle) {
    const SphericalRectangle rectangle = quad.rectangle();
    if (rectangle.solid_angle() >= least_rectangle_angle) {
      const auto [wi, distance] = rectangle.sample(s, t);
      return {.wi = wi, .distance = distance, .pdf = 1 / rectangle.solid_angle()};
    }
  } else {
    const SphericalTriangle near = quad.near_half(), far = quad.far_half();
    const double total = near.solid_angle() + far.solid_angle();
    if (total >= least_triangle_angle) {
      const double angle = s * total;
      const Vec3d wi = angle < near.solid_angle()
                           ? near.sample(angle / near.solid_angle(), t)
                           : far.sample((angle - near.solid_angle()) / far.solid_angle(), t);
      return along(quad.plane, wi, 1 / total);
    }
  }
  ShapeSample sample = towards(quad.corner + quad.u * s + quad.v * t, 0);
  sample.pdf = quad.plane.pdf_by_area(1, sample.distance, sample.wi);
  return sample;
}

namespace {

/// A lane of floats for each of several requests; a vector's three rows stand together.
class FloatRows {
 public:
  enum Row : std::size_t { corner, place = 3, u = 6, v = 9, surface = 12, s = 15, t, row_count };

  void set(std::size_t row, std::size_t lane, float value) { rows_[row][lane] = value; }
  void set(std::size_t row, std::size_t lane, const Vec3& value) {
    set(row, lane, value.x);
    set(row + 1, lane, value.y);
    set(row + 2, lane, value.z);
  }
  [[nodiscard]] WideDouble number(std::size_t row) const { return widened(rows_[row].data()); }
  [[nodiscard]] Vector3<WideDouble> vector(std::size_t row) const {
    return {number(row), number(row + 1), number(row + 2)};
  }

 private:
  std::array<std::array<float, WideDouble::lanes>, row_count> rows_;
};

/// The lights of several requests, each seen from its own point.
struct SeenRectangles {
  using Vector = Vector3<WideDouble>;
  Vector corner, u, v, surface;
  WideDouble inverse_length_u, inverse_length_v, s, t;

  explicit SeenRectangles(std::span<const RectangleRequest> asked) {
    FloatRows rows;
    std::array<std::array<double, WideDouble::lanes>, 2> inverse_lengths;
    for (std::size_t lane = 0; lane < WideDouble::lanes; ++lane) {
      const RectangleRequest& request = asked[std::min(lane, asked.size() - 1)];
      const QuadLight& quad = *request.light;
      rows.set(FloatRows::corner, lane, quad.corner);
      rows.set(FloatRows::place, lane, request.context->p);
      rows.set(FloatRows::u, lane, quad.edge_u);
      rows.set(FloatRows::v, lane, quad.edge_v);
      rows.set(FloatRows::surface, lane, request.context->n);
      rows.set(FloatRows::s, lane, request.u.x);
      rows.set(FloatRows::t, lane, request.u.y);
      inverse_lengths[0][lane] = quad.inverse_length_u;
      inverse_lengths[1][lane] = quad.inverse_length_v;
    }
    corner = rows.vector(FloatRows::corner) - rows.vector(FloatRows::place);
    u = rows.vector(FloatRows::u);
    v = rows.vector(FloatRows::v);
    surface = rows.vector(FloatRows::surface);
    s = rows.number(FloatRows::s);
    t = rows.number(FloatRows::t);
    inverse_length_u = WideDouble::load(inverse_lengths[0].data());
    inverse_length_v = WideDouble::load(inverse_lengths[1].data());
  }
  /// As Plane::below.
  [[nodiscard]] WideDouble below() const { return dot(corner, cross(u, v)); }
  [[nodiscard]] WideDouble highest() const { return highest_of(corner, u, v, surface); }
  [[nodiscard]] BasicSphericalRectangle<WideDouble> rectangle() const {
    return {corner, u, v, inverse_length_u, inverse_length_v};
  }
};

}  // namespace

void sample_rectangles(std::span<const RectangleRequest> asked, std::span<ShapeSample> drawn) {
  assert(asked.size() <= WideDouble::lanes);
  if (asked.empty()) return;
  const SeenRectangles seen(asked);
  const WideDouble below = seen.below(), highest = seen.highest();
  const BasicSphericalRectangle<WideDouble> rectangle = seen.rectangle();
  const auto [wi, distance] = rectangle.sample(seen.s, seen.t);
  const WideDouble angle = rectangle.solid_angle(), pdf = 1.0 / angle;
  for (std::size_t lane = 0; lane < asked.size(); ++lane) {
    const auto& [light, two_sided, context, uv] = asked[lane];
    drawn[lane] = {};
    if (!sees(two_sided, below[lane]) || !stands_over(highest[lane], context->n)) continue;
    if (!(angle[lane] >= least_rectangle_angle))
      drawn[lane] = sample_shape(*light, two_sided, *context, uv);
    else
      drawn[lane] = {
          .wi = {wi.x[lane], wi.y[lane], wi.z[lane]}, .distance = distance[lane], .pdf = pdf[lane]};
  }
}

double pdf_shape(const QuadLight& light, bool two_sided, const LightContext& context,
                 const LightHit& hit) {
  const SeenQuad quad(light, context.p);
  if (!quad.visible(two_sided, context.n)) return 0;
  if (light.rectangle) {
    const double angle = quad.rectangle().solid_angle();
    if (angle >= least_rectangle_angle) return 1 / angle;
  } else {
    const double angle = quad.near_half().solid_angle() + quad.far_half().solid_angle();
    if (angle >= least_triangle_angle) return 1 / angle;
  }
  return quad.plane.pdf_by_area(1, hit.distance, to_double(hit.wi));
}

namespace {

struct SeenTriangle {
  Vec3d a, b, c;
  Plane plane;

  SeenTriangle(const TriangleLight& triangle, const Vec3& p)
      : a(to_double(triangle.a) - to_double(p)),
        b(to_double(triangle.b) - to_double(p)),
        c(to_double(triangle.c) - to_double(p)),
        plane(a, b - a, c - a) {}

  [[nodiscard]] bool visible(bool two_sided, const Vec3& surface) const {
    if (!plane.visible(two_sided)) return false;
    const Vec3d n = to_double(surface);
    return std::max({dot(a, n), dot(b, n), dot(c, n)}) > 0 || surface == Vec3{};
  }
};

}  // namespace

ShapeSample sample_shape(const TriangleLight& light, bool two_sided, const LightContext& context,
                         Vec2 uv) {
  const SeenTriangle triangle(light, context.p);
  if (!triangle.visible(two_sided, context.n)) return {};
  const SphericalTriangle spherical(triangle.a, triangle.b, triangle.c);
  if (spherical.solid_angle() >= least_triangle_angle) {
    return along(triangle.plane, spherical.sample(uv.x, uv.y), 1 / spherical.solid_angle());
  }
  const Vec2 b = square_to_triangle(uv);
  const Vec3d point = triangle.a + (triangle.b - triangle.a) * static_cast<double>(b.x) +
                      (triangle.c - triangle.a) * static_cast<double>(b.y);
  ShapeSample sample = towards(point, 0);
  sample.pdf = triangle.plane.pdf_by_area(0.5, sample.distance, sample.wi);
  return sample;
}

double pdf_shape(const TriangleLight& light, bool two_sided, const LightContext& context,
                 const LightHit& hit) {
  const SeenTriangle triangle(light, context.p);
  if (!triangle.visible(two_sided, context.n)) return 0;
  const SphericalTriangle spherical(triangle.a, triangle.b, triangle.c);
  if (spherical.solid_angle() >= least_triangle_angle) return 1 / spherical.solid_angle();
  return triangle.plane.pdf_by_area(0.5, hit.distance, to_double(hit.wi));
}

}  // namespace tessera::render
