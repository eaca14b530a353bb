#include "worker/render/lights/environment_map.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "worker/render/fastmath.hpp"

namespace tessera::render {
namespace {

/// Cells of the density: finer ones cost memory and find little more.
constexpr int cells_across_most = 2048;

/// The cell in which the edge before texel `index` of `size` lies; `more` = −1: the one before it.
std::size_t cell_at(int index, int cells, int size, int more = 0) {
  return static_cast<std::size_t>((std::int64_t{index} * cells + more) / size);
}

/// Per solid angle, of a density over the picture, where sin θ is `sine`.
double pdf_of(double density, double sine) { return density / (2 * pi_d * pi_d * sine); }

Color color_of(const Texel& texel) { return {texel[0], texel[1], texel[2]}; }

}  // namespace

EnvironmentMap::EnvironmentMap(image::Texels&& picture, scene::ColorSpace space, double turn)
    : picture_(std::move(picture), space, Pyramid::Levels::first), turn_(turn / (2 * pi_d)) {
  take_mean();
  weigh();
}

void EnvironmentMap::take_mean() {
  const Pyramid::Level& level = picture_.level(0);
  double all = 0;
  std::array<double, 3> sum{};
  for (int y = 0; y < level.height; ++y) {
    const double sine = fast::sin(pi_d * (y + 0.5) / level.height);
    for (int x = 0; x < level.width; ++x) {
      const Texel texel = picture_.texel(level, x, y);
      all += sine;
      for (std::size_t c = 0; c < 3; ++c) sum[c] += double{texel[c]} * sine;
    }
  }
  mean_ = to_color({sum[0] / all, sum[1] / all, sum[2] / all});
}

void EnvironmentMap::weigh() {
  const Pyramid::Level& level = picture_.level(0);
  const int step_x = (level.width + cells_across_most - 1) / cells_across_most;
  const int step_y = (level.height + cells_across_most / 2 - 1) / (cells_across_most / 2);
  const int columns = (level.width + step_x - 1) / step_x;
  const int rows = (level.height + step_y - 1) / step_y;
  const double mean = double{luminance(mean_)};
  // Cells that are cut by an edge of texels take half of the texel's light each.
  const auto first_cell = [&](int x) { return cell_at(x, columns, level.width); };
  const auto last_cell = [&](int x) { return cell_at(x + 1, columns, level.width, -1); };
  for (int row = 0; row < rows; ++row) {
    std::vector<double> cells(static_cast<std::size_t>(columns)), brighter(cells);
    const auto add = [&](int x, double light, double above_mean) {
      for (const std::size_t cell : {first_cell(x), last_cell(x)}) {
        cells[cell] += 0.5 * light;
        brighter[cell] += 0.5 * above_mean;
      }
    };
    const auto of_level = std::int64_t{row} * level.height;
    const int top = static_cast<int>(of_level / rows);
    const int bottom = static_cast<int>((of_level + level.height - 1) / rows);
    // A row of texels looks a texel further on either side: there bilinear light comes from it.
    for (int y = std::max(top - 1, 0); y <= std::min(bottom + 1, level.height - 1); ++y) {
      const bool own = y >= top && y <= bottom;
      const double weight = fast::sin(pi_d * (y + 0.5) / level.height) * (own ? 1 : 0.125);
      for (int x = 0; x < level.width; ++x) {
        const double light = double{luminance(color_of(picture_.texel(level, x, y)))};
        const double all = std::max(0.0, light) * weight;
        const double above = std::max(0.0, light - mean) * weight;
        add(x, all, above);
        add((x + 1) % level.width, 0.125 * all, 0.125 * above);
        add((x + level.width - 1) % level.width, 0.125 * all, 0.125 * above);
      }
    }
    plain_.add_row(cells);
    compensated_.add_row(brighter);
  }
  plain_.finish();
  compensated_.finish();
  if (!compensated_.any()) compensated_ = plain_;
}

CellDensity::Point EnvironmentMap::point_of(const Vec3d& d) const {
  const double x = 0.5 - fast::atan2(-d.z, d.x) / (2 * pi_d) + turn_;
  return {x - std::floor(x), fast::acos(d.y) / pi_d};
}

Color EnvironmentMap::radiance(const Vec3d& direction) const {
  return radiance_at(point_of(direction));
}

Color EnvironmentMap::radiance_at(const CellDensity::Point& point) const {
  const Pyramid::Level& level = picture_.level(0);
  const double x = point.x * level.width - 0.5, y = point.y * level.height - 0.5;
  const int left = static_cast<int>(std::floor(x)), top = static_cast<int>(std::floor(y));
  const auto share_x = static_cast<float>(x - left), share_y = static_cast<float>(y - top);
  const auto texel = [&](int column, int row) {
    const int wrapped = column < 0 ? level.width - 1 : column >= level.width ? 0 : column;
    return color_of(picture_.texel(level, wrapped, std::clamp(row, 0, level.height - 1)));
  };
  const auto mixed_row = [&](int row) {
    return texel(left, row) * (1 - share_x) + texel(left + 1, row) * share_x;
  };
  return mixed_row(top) * (1 - share_y) + mixed_row(top + 1) * share_y;
}

double EnvironmentMap::pdf(const Vec3d& direction) const { return pdf_by(compensated_, direction); }

double EnvironmentMap::pdf_all(const Vec3d& direction) const { return pdf_by(plain_, direction); }

double EnvironmentMap::pdf_by(const CellDensity& cells, const Vec3d& direction) const {
  const double sine = std::sqrt(direction.x * direction.x + direction.z * direction.z);
  if (!(sine > 0)) return 0;
  return pdf_of(cells.density(point_of(direction)), sine);
}

EnvironmentMap::Drawn EnvironmentMap::sample(Vec2 u) const { return sample_by(compensated_, u); }

EnvironmentMap::Drawn EnvironmentMap::sample_all(Vec2 u) const { return sample_by(plain_, u); }

EnvironmentMap::Drawn EnvironmentMap::sample_by(const CellDensity& cells, Vec2 u) const {
  if (!(luminance(mean_) > 0)) return {};
  const auto [at, density] = cells.sample(u);
  const auto [sine, cosine] = fast::sincos(pi_d * at.y);
  if (!(sine > 0)) return {};
  const auto [sin_around, cos_around] = fast::sincos(2 * pi_d * (0.5 - (at.x - turn_)));
  return {.direction = {sine * cos_around, cosine, -sine * sin_around},
          .radiance = radiance_at(at),
          .pdf = pdf_of(density, sine)};
}

}  // namespace tessera::render
