#include "worker/render/lights/cell_density.hpp"

#include <algorithm>

namespace tessera::render {
namespace {

/// Running sums of `weights`, from 0 to 1; all alike where there is no weight. Gives their sum.
double accumulate(std::span<const double> weights, std::vector<float>& out) {
  double total = 0;
  for (const double weight : weights) total += weight;
  double sum = 0;
  out.push_back(0);
  for (const double weight : weights) {
    sum += total > 0 ? weight / total : 1 / static_cast<double>(weights.size());
    out.push_back(static_cast<float>(std::min(sum, 1.0)));
  }
  out.back() = 1;
  return total;
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

std::size_t cell_of(double at, std::size_t cells) {
  const auto count = static_cast<int>(cells);
  return static_cast<std::size_t>(
      std::clamp(static_cast<int>(at * static_cast<double>(count)), 0, count - 1));
}

}  // namespace

void CellDensity::add_row(std::span<const double> weights) {
  columns_ = weights.size();
  row_weights_.push_back(accumulate(weights, in_row_));
}

void CellDensity::finish() {
  any_ = accumulate(row_weights_, of_rows_) > 0;
  row_weights_ = {};
}

CellDensity::Point CellDensity::sample(Vec2 u) const {
  const Found row = find(of_rows_, u.y);
  const std::size_t stride = columns_ + 1;
  const Found column = find(std::span(in_row_).subspan(row.cell * stride, stride), u.x);
  return {(static_cast<double>(column.cell) + column.within) / static_cast<double>(columns_),
          (static_cast<double>(row.cell) + row.within) / static_cast<double>(rows())};
}

double CellDensity::density(const Point& point) const {
  const std::size_t row = cell_of(point.y, rows()), column = cell_of(point.x, columns_);
  const std::size_t first = row * (columns_ + 1) + column;
  const double share = (double{of_rows_[row + 1]} - double{of_rows_[row]}) *
                       (double{in_row_[first + 1]} - double{in_row_[first]});
  return share * static_cast<double>(columns_) * static_cast<double>(rows());
}

}  // namespace tessera::render
