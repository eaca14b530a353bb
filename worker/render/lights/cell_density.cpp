#include "worker/render/lights/cell_density.hpp"

#include <algorithm>
#include <cassert>
#include <limits>

namespace tessera::render {
namespace {

/// So far, in cells, points keep off edges, so that what is rounded on the way to a direction and
/// back stays in the cell whose density it was drawn by.
constexpr double off_the_edge = 1e-9;

struct Found {
  std::size_t cell;
  double within;  ///< 0…1, but for the edges
};
/// The cell in whose stretch of the running sums `u` lies; never one without a stretch. By a guide
/// to where the search begins it takes a step or two in the mean, of a thousand cells too (Chen and
/// Asau, "On Generating Random Variates from an Empirical Distribution", 1974).
Found find(std::span<const float> sums, std::span<const std::uint16_t> guides, float u) {
  const std::size_t last = guides.size() - 1;
  const auto share = static_cast<std::size_t>(u * static_cast<float>(guides.size()));
  std::size_t cell = guides[std::min(share, last)];
  while (cell > 0 && sums[cell] > u) --cell;
  while (cell < last && sums[cell + 1] <= u) ++cell;
  const double low = double{sums[cell]}, high = double{sums[cell + 1]};
  const double within = high > low ? (double{u} - low) / (high - low) : 0.5;
  return {cell, std::clamp(within, off_the_edge, 1 - off_the_edge)};
}

std::size_t cell_of(double at, std::size_t cells) {
  const auto count = static_cast<int>(cells);
  return static_cast<std::size_t>(
      std::clamp(static_cast<int>(at * static_cast<double>(count)), 0, count - 1));
}

}  // namespace

double CellDensity::Sums::add(std::span<const double> weights) {
  assert(weights.size() - 1 <= std::numeric_limits<std::uint16_t>::max());
  double total = 0;
  for (const double weight : weights) total += weight;
  const std::size_t first = sums.size();
  const auto cells = static_cast<double>(weights.size());
  double sum = 0;
  sums.push_back(0);
  for (const double weight : weights) {
    sum += total > 0 ? weight / total : 1 / cells;
    sums.push_back(static_cast<float>(std::min(sum, 1.0)));
  }
  sums.back() = 1;
  std::size_t cell = 0;
  for (std::size_t share = 0; share < weights.size(); ++share) {
    const double begin = static_cast<double>(share) / cells;
    while (cell + 1 < weights.size() && double{sums[first + cell + 1]} <= begin) ++cell;
    guides.push_back(static_cast<std::uint16_t>(cell));
  }
  return total;
}

void CellDensity::add_row(std::span<const double> weights) {
  columns_ = weights.size();
  row_weights_.push_back(in_row_.add(weights));
}

void CellDensity::finish() {
  any_ = of_rows_.add(row_weights_) > 0;
  row_weights_ = {};
}

CellDensity::Drawn CellDensity::sample(Vec2 u) const {
  const Found row = find(of_rows_.sums, of_rows_.guides, u.y);
  const std::size_t stride = columns_ + 1;
  const Found column = find(std::span(in_row_.sums).subspan(row.cell * stride, stride),
                            std::span(in_row_.guides).subspan(row.cell * columns_, columns_), u.x);
  const Point point{
      (static_cast<double>(column.cell) + column.within) / static_cast<double>(columns_),
      (static_cast<double>(row.cell) + row.within) / static_cast<double>(rows())};
  return {point, density_of(row.cell, column.cell)};
}

double CellDensity::density(const Point& point) const {
  return density_of(cell_of(point.y, rows()), cell_of(point.x, columns_));
}

double CellDensity::density_of(std::size_t row, std::size_t column) const {
  const std::vector<float>& along = in_row_.sums;
  const std::size_t first = row * (columns_ + 1) + column;
  const double share = (double{of_rows_.sums[row + 1]} - double{of_rows_.sums[row]}) *
                       (double{along[first + 1]} - double{along[first]});
  return share * static_cast<double>(columns_) * static_cast<double>(rows());
}

}  // namespace tessera::render
