#include "scenes/generate/pot.hpp"

#include <algorithm>
#include <cmath>

#include "scenes/generate/noise.hpp"

namespace tessera::generate {

namespace {

/// A point of the outline: distance from the axis, height.
using Corner = std::array<double, 2>;

struct Form {
  double height;                ///< metres
  std::vector<Corner> outline;  ///< of the outer wall, in heights, from the foot to the lip
};

/// Bottle, bowl, jar, vase, beaker, gourd.
const std::array<Form, 6>& forms() {
  static const std::array<Form, 6> all{{
      {0.30, {{.19, 0}, {.29, .10}, {.33, .32}, {.24, .56}, {.09, .74}, {.075, .90}, {.115, 1}}},
      {0.13, {{.34, 0}, {.37, .07}, {.66, .40}, {.82, .78}, {.86, 1}}},
      {0.22, {{.28, 0}, {.41, .20}, {.47, .48}, {.41, .76}, {.30, .90}, {.34, 1}}},
      {0.28, {{.22, 0}, {.21, .12}, {.29, .45}, {.36, .72}, {.25, .90}, {.30, 1}}},
      {0.18, {{.30, 0}, {.31, .30}, {.34, .70}, {.37, 1}}},
      {0.27, {{.24, 0}, {.36, .14}, {.37, .34}, {.19, .54}, {.25, .72}, {.22, .86}, {.13, 1}}},
  }};
  return all;
}

constexpr double wall = 0.009;  ///< metres

double chance(int kind, int what) { return 0.5 + 0.5 * lattice(kind, what, 8001); }

const Form& form_of(int kind) {
  return forms()[static_cast<std::size_t>((kind * 5 + kind / 6) % 6)];
}
double height_of(int kind) { return form_of(kind).height * (0.88 + 0.24 * chance(kind, 0)); }

/// The whole outline in metres: the outer wall, a round lip, the inner wall down to the middle.
std::vector<Corner> corners_of(int kind) {
  const double height = height_of(kind), girth = height * (0.92 + 0.16 * chance(kind, 1));
  std::vector<Corner> out;
  for (const Corner& c : form_of(kind).outline) out.push_back({c[0] * girth, c[1] * height});
  const std::size_t lip = out.size() - 1;
  out.push_back({out[lip][0] - 0.5 * wall, height + 0.3 * wall});
  // As far from the outer wall everywhere, so that the two never cross.
  for (std::size_t i = lip; i >= 1; --i) {
    const Corner &below = out[i - 1], &above = out[std::min(i + 1, lip)];
    const Point inwards = unit({below[1] - above[1], above[0] - below[0], 0});
    out.push_back({out[i][0] + wall * inwards[0], out[i][1] + wall * inwards[1]});
  }
  out.push_back({0.5 * out[0][0], 1.4 * wall});
  out.push_back({0.001, 1.3 * wall});
  return out;
}

/// Catmull and Rom's curve through the corners, at `at` (0…corners − 1).
Corner on_curve(const std::vector<Corner>& corners, double at) {
  const std::size_t last = corners.size() - 1;
  const std::size_t i = std::min(static_cast<std::size_t>(at), last - 1);
  const double t = at - static_cast<double>(i);
  const Corner &b = corners[i], &c = corners[i + 1];
  const Corner &a = corners[i == 0 ? 0 : i - 1], &d = corners[std::min(i + 2, last)];
  Corner out;
  for (std::size_t k = 0; k < 2; ++k)
    out[k] =
        b[k] +
        0.5 * t *
            (c[k] - a[k] +
             t * (2 * a[k] - 5 * b[k] + 4 * c[k] - d[k] + t * (3 * (b[k] - c[k]) + d[k] - a[k])));
  out[0] = std::max(out[0], 0.0005);
  return out;
}

/// `count` + 1 points of the outline at equal distances along it.
std::vector<Corner> outline_of(int kind, std::size_t count) {
  const std::vector<Corner> corners = corners_of(kind);
  const std::size_t steps = 16 * count;
  std::vector<Corner> fine;
  std::vector<double> lengths{0};
  for (std::size_t i = 0; i <= steps; ++i) {
    fine.push_back(on_curve(
        corners, static_cast<double>(i * (corners.size() - 1)) / static_cast<double>(steps)));
    if (i == 0) continue;
    const double dx = fine[i][0] - fine[i - 1][0], dy = fine[i][1] - fine[i - 1][1];
    lengths.push_back(lengths.back() + std::sqrt(dx * dx + dy * dy));
  }
  std::vector<Corner> out;
  for (std::size_t i = 0; i <= count; ++i) {
    const double wanted = lengths.back() * static_cast<double>(i) / static_cast<double>(count);
    const auto found = std::lower_bound(lengths.begin(), lengths.end(), wanted);
    out.push_back(fine[std::min(static_cast<std::size_t>(found - lengths.begin()), steps)]);
  }
  return out;
}

/// How far the clay stands out at a point of the smooth form, metres. `turn` is 0…1 around.
double relief(int kind, const Point& p, double turn, double radius) {
  const double shift = 31.7 * kind;
  double out = 0.0035 * noise({9 * p[0] + shift, 9 * p[1], 9 * p[2]});
  out += 0.0009 * noise({55 * p[0], 55 * p[1] + shift, 55 * p[2]});
  const double rings = 190 + 120 * chance(kind, 3);  // the potter's fingers, a spiral
  out += 0.0007 * noise({rings * p[1] + 1.0 * turn, shift, 0.5});
  if (chance(kind, 4) > 0.6) {
    const double flutes = 9 + std::floor(14 * chance(kind, 5));
    const double wave = on_circle(flutes * turn)[0];
    out += 0.045 * radius * std::min(1.0, 4 * radius / height_of(kind)) * wave * wave;
  }
  return out * std::min(1.0, 40 * radius);
}

struct Grid {
  std::size_t around, along;
  std::vector<Point> points;  ///< (along + 1) rows of `around`
  [[nodiscard]] const Point& at(std::size_t i, std::size_t j) const {
    return points[j * around + i % around];
  }
};

Grid grid_of(int kind, std::size_t around, std::size_t along) {
  const std::vector<Corner> outline = outline_of(kind, along);
  Grid out{around, along, {}};
  for (std::size_t j = 0; j <= along; ++j) {
    const Corner &before = outline[j == 0 ? 0 : j - 1], &after = outline[std::min(j + 1, along)];
    // Outwards: to the right of the way along the outline.
    const Point normal = unit({after[1] - before[1], before[0] - after[0], 0});
    // The lip is about the middle of the way, and smooth; so is the inside.
    const double outside =
        std::clamp(12 - 25 * static_cast<double>(j) / static_cast<double>(along), 0.0, 1.0);
    for (std::size_t i = 0; i < around; ++i) {
      const double turn = static_cast<double>(i) / static_cast<double>(around);
      const auto [c, s] = on_circle(turn);
      const double r = outline[j][0], y = outline[j][1];
      const double d = outside * relief(kind, {r * c, y, r * s}, turn, r);
      const double out_r = r + d * normal[0], out_y = std::max(0.0, y + d * normal[1]);
      out.points.push_back({out_r * c, out_y, out_r * s});
    }
  }
  return out;
}

Point difference(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

std::array<float, 3> to_float(const Point& p) {
  return {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
}

void add_vertex(Pot& out, const Grid& grid, std::size_t i, std::size_t j) {
  const Point along_u = unit(difference(grid.at(i + 1, j), grid.at(i + grid.around - 1, j)));
  const Point along_v =
      difference(grid.at(i, std::min(j + 1, grid.along)), grid.at(i, j == 0 ? 0 : j - 1));
  const Point normal = unit({along_v[1] * along_u[2] - along_v[2] * along_u[1],
                             along_v[2] * along_u[0] - along_v[0] * along_u[2],
                             along_v[0] * along_u[1] - along_v[1] * along_u[0]});
  out.positions.push_back(to_float(grid.at(i, j)));
  out.normals.push_back(to_float(normal));
  // u runs to the right as seen from outside, which is against the turn.
  const auto tangent = to_float({-along_u[0], -along_u[1], -along_u[2]});
  out.tangents.push_back({tangent[0], tangent[1], tangent[2], 1});
  out.uvs.push_back({1 - static_cast<float>(i) / static_cast<float>(grid.around),
                     1 - static_cast<float>(j) / static_cast<float>(grid.along)});
}

}  // namespace

Pot pot(int kind, std::size_t around, std::size_t along) {
  const Grid grid = grid_of(kind, around, along);
  Pot out;
  for (std::size_t j = 0; j <= along; ++j)
    for (std::size_t i = 0; i <= around; ++i) add_vertex(out, grid, i, j);
  const auto row = static_cast<std::uint32_t>(around + 1);
  for (std::uint32_t j = 0; j < along; ++j)
    for (std::uint32_t i = 0; i < around; ++i) {
      const std::uint32_t a = j * row + i, b = a + 1, c = b + row, d = a + row;
      out.indices.insert(out.indices.end(), {a, d, b, b, d, c});
    }
  return out;
}

double pot_width(int kind) {
  double widest = 0;
  for (const Corner& corner : corners_of(kind)) widest = std::max(widest, 2 * corner[0]);
  return widest;
}

}  // namespace tessera::generate
