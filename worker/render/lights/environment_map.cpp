#include "worker/render/lights/environment_map.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "worker/render/fastmath.hpp"

namespace tessera::render {
namespace {

/// Cells of the density: finer ones cost memory and find little more.
constexpr int cells_across_most = 2048;

/// Running sums of `weights`, from 0 to 1; all alike where there is no weight.
void accumulate(std::span<const double> weights, std::span<float> out) {
  double total = 0;
  for (const double weight : weights) total += weight;
  double sum = 0;
  out[0] = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    sum += total > 0 ? weights[i] / total : 1 / static_cast<double>(weights.size());
    out[i + 1] = static_cast<float>(std::min(sum, 1.0));
  }
  out[weights.size()] = 1;
}

struct Found {
  std::size_t cell;
  double within;  ///< 0…1
};
/// The cell in whose stretch of the running sums `u` lies; never one without a stretch.
Found find(std::span<const float> sums, float u) {
  const auto above = std::upper_bound(sums.begin() + 1, sums.end() - 1, u);
  const auto cell = static_cast<std::size_t>(above - sums.begin()) - 1;
  const double low = double{sums[cell]}, high = double{sums[cell + 1]};
  const double within = high > low ? (double{u} - low) / (high - low) : 0.5;
  return {cell, std::clamp(within, 0.0, 1.0)};
}

std::size_t cell_of(double at, int cells) {
  return static_cast<std::size_t>(
      std::clamp(static_cast<int>(at * static_cast<double>(cells)), 0, cells - 1));
}

/// The cell in which the edge before texel `index` of `size` lies; `more` = −1: the one before it.
std::size_t cell_at(int index, int cells, int size, int more = 0) {
  return static_cast<std::size_t>((std::int64_t{index} * cells + more) / size);
}

Color color_of(const Texel& texel) { return {texel[0], texel[1], texel[2]}; }

}  // namespace

EnvironmentMap::EnvironmentMap(image::Texels&& picture, scene::ColorSpace space, double turn)
    : picture_(std::move(picture), space, Pyramid::Levels::first), turn_(turn / (2 * pi_d)) {
  weigh();
}

void EnvironmentMap::weigh() {
  const Pyramid::Level& level = picture_.level(0);
  const int step_x = (level.width + cells_across_most - 1) / cells_across_most;
  const int step_y = (level.height + cells_across_most / 2 - 1) / (cells_across_most / 2);
  columns_ = (level.width + step_x - 1) / step_x;
  rows_ = (level.height + step_y - 1) / step_y;
  const auto columns = static_cast<std::size_t>(columns_);
  in_row_.resize(static_cast<std::size_t>(rows_) * (columns + 1));
  of_rows_.resize(static_cast<std::size_t>(rows_) + 1);
  std::vector<double> of_row;
  double all = 0;
  std::array<double, 3> mean{};
  // Cells that are cut by an edge of texels take half of the texel's light each.
  const auto first_cell = [&](int x) { return cell_at(x, columns_, level.width); };
  const auto last_cell = [&](int x) { return cell_at(x + 1, columns_, level.width, -1); };
  for (int row = 0; row < rows_; ++row) {
    std::vector<double> cells(columns, 0.0);
    const auto add = [&](int x, double light) {
      cells[first_cell(x)] += 0.5 * light;
      cells[last_cell(x)] += 0.5 * light;
    };
    const auto of_level = std::int64_t{row} * level.height;
    const int top = static_cast<int>(of_level / rows_);
    const int bottom = static_cast<int>((of_level + level.height - 1) / rows_);
    // A row of texels looks a texel further on either side: there bilinear light comes from it.
    for (int y = std::max(top - 1, 0); y <= std::min(bottom + 1, level.height - 1); ++y) {
      const bool own = y >= top && y <= bottom;
      const double sine = fast::sin(pi_d * (y + 0.5) / level.height);
      const bool first = own && cell_at(y, rows_, level.height) == static_cast<std::size_t>(row);
      for (int x = 0; x < level.width; ++x) {
        const Texel texel = picture_.texel(level, x, y);
        const double light =
            std::max(0.0, double{luminance(color_of(texel))}) * sine * (own ? 1 : 0.125);
        add(x, light);
        add((x + 1) % level.width, 0.125 * light);
        add((x + level.width - 1) % level.width, 0.125 * light);
        if (!first) continue;
        all += sine;
        for (std::size_t c = 0; c < 3; ++c) mean[c] += double{texel[c]} * sine;
      }
    }
    accumulate(cells, std::span(in_row_).subspan(static_cast<std::size_t>(row) * (columns + 1),
                                                 columns + 1));
    double sum = 0;
    for (const double cell : cells) sum += cell;
    of_row.push_back(sum);
  }
  accumulate(of_row, of_rows_);
  mean_ = to_color({mean[0] / all, mean[1] / all, mean[2] / all});
}

EnvironmentMap::Point EnvironmentMap::point_of(const Vec3d& d) const {
  const double x = 0.5 - fast::atan2(-d.z, d.x) / (2 * pi_d) + turn_;
  return {x - std::floor(x), fast::acos(d.y) / pi_d};
}

Color EnvironmentMap::radiance(const Vec3d& direction) const {
  const Pyramid::Level& level = picture_.level(0);
  const Point point = point_of(direction);
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

double EnvironmentMap::pdf(const Vec3d& direction) const {
  const Point point = point_of(direction);
  const double sine = std::sqrt(direction.x * direction.x + direction.z * direction.z);
  if (!(sine > 0)) return 0;
  const std::size_t row = cell_of(point.y, rows_), column = cell_of(point.x, columns_);
  const std::size_t first = row * (static_cast<std::size_t>(columns_) + 1) + column;
  const double share = (double{of_rows_[row + 1]} - double{of_rows_[row]}) *
                       (double{in_row_[first + 1]} - double{in_row_[first]});
  return share * columns_ * rows_ / (2 * pi_d * pi_d * sine);
}

EnvironmentMap::Drawn EnvironmentMap::sample(Vec2 u) const {
  if (!(luminance(mean_) > 0)) return {};
  const Found row = find(of_rows_, u.y);
  const auto columns = static_cast<std::size_t>(columns_);
  const Found column = find(std::span(in_row_).subspan(row.cell * (columns + 1), columns + 1), u.x);
  const double x = (static_cast<double>(column.cell) + column.within) / columns_ - turn_;
  const double y = (static_cast<double>(row.cell) + row.within) / rows_;
  const auto [sine, cosine] = fast::sincos(pi_d * y);
  const auto [sin_around, cos_around] = fast::sincos(2 * pi_d * (0.5 - x));
  const Vec3d direction{sine * cos_around, cosine, -sine * sin_around};
  return {direction, pdf(direction)};
}

}  // namespace tessera::render
