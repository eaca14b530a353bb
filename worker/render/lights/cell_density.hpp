#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "worker/render/vec.hpp"

namespace tessera::render {

/// A density over the unit square that is constant in each cell of a grid, and points drawn by it.
/// What is kept are running sums, over the rows and along each.
class CellDensity {
 public:
  /// The weights of one row more, from the upper one; all rows have as many.
  void add_row(std::span<const double> weights);
  /// After the last row.
  void finish();

  /// 0 ≤ x, y ≤ 1.
  struct Point {
    double x, y;
  };
  [[nodiscard]] Point sample(Vec2 u) const;
  /// Per unit of the square's area; its integral is 1.
  [[nodiscard]] double density(const Point& point) const;
  /// False: no cell has a weight, and all are alike to sample().
  [[nodiscard]] bool any() const { return any_; }

 private:
  [[nodiscard]] std::size_t rows() const { return of_rows_.size() - 1; }

  std::size_t columns_ = 0;
  bool any_ = false;
  std::vector<double> row_weights_;  ///< until finish()
  std::vector<float> in_row_;        ///< rows of columns_ + 1, each from 0 to 1
  std::vector<float> of_rows_;       ///< one more than rows, from 0 to 1
};

}  // namespace tessera::render
