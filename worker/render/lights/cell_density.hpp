#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "worker/render/vec.hpp"

namespace tessera::render {

/// A density over the unit square that is constant in each cell of a grid, and points drawn by it.
/// What is kept are running sums, over the rows and along each, of at most 65536 cells.
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
  struct Drawn {
    Point point;
    double density;  ///< of the cell that the point lies within
  };
  [[nodiscard]] Drawn sample(Vec2 u) const;
  /// Per unit of the square's area; its integral is 1.
  [[nodiscard]] double density(const Point& point) const;
  /// False: no cell has a weight, and all are alike to sample().
  [[nodiscard]] bool any() const { return any_; }

 private:
  /// Running sums from 0 to 1, of one weight or of many, and where to look for a number among them:
  /// one after the other, stretches of as many.
  struct Sums {
    std::vector<float> sums;            ///< one more than the weights of a stretch
    std::vector<std::uint16_t> guides;  ///< of each like share of 0…1, the cell that it begins in
    /// Adds a stretch, all alike where there is no weight. Gives the weights' sum.
    double add(std::span<const double> weights);
  };

  [[nodiscard]] std::size_t rows() const { return of_rows_.sums.size() - 1; }
  [[nodiscard]] double density_of(std::size_t row, std::size_t column) const;

  std::size_t columns_ = 0;
  bool any_ = false;
  std::vector<double> row_weights_;  ///< until finish()
  Sums in_row_;                      ///< a stretch for each row
  Sums of_rows_;                     ///< one stretch
};

}  // namespace tessera::render
