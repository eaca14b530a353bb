#pragma once
#include <array>
#include <bit>
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "worker/render/vec.hpp"

namespace tessera::render {

enum class FilterKind : std::uint8_t { box, tent, gaussian, blackman_harris };

/// From a name of the table in filter.cpp; throws Error{bad_input} that lists the valid names.
FilterKind filter_kind(std::string_view name);
/// The valid names.
std::vector<std::string_view> filter_names();

class Filter;
/// Filter(kind, width); the one that this thread asked for last is not tabulated anew.
std::shared_ptr<const Filter> shared_filter(FilterKind kind, double width);

/// A pixel filter, by importance: a film position is drawn from the filter's own density around the
/// pixel's centre, and every sample then has the weight 1 (Ernst, Stamminger, Greiner, "Filter
/// importance sampling", 2006). A sample belongs to its own pixel alone, so tiles have no borders.
/// All filters are separable, symmetric and nowhere negative.
class Filter {
 public:
  /// `width` in pixels from edge to edge; 0 is the kind's default: box 1, tent 2, Gaussian 3 (σ is
  /// a sixth of the width), Blackman-Harris 3.
  explicit Filter(FilterKind kind, double width = 0);

  /// The offset from the pixel's centre, in pixels, each coordinate within half the width. u in [0,
  /// 1)².
  [[nodiscard]] Vec2 sample(Vec2 u) const { return {sample1(u.x), sample1(u.y)}; }
  /// The density of one coordinate of sample(), per pixel; 0 outside. The filter itself,
  /// normalised.
  [[nodiscard]] double density(double offset) const;

  [[nodiscard]] FilterKind kind() const { return kind_; }
  [[nodiscard]] double width() const { return width_; }
  /// As it was given: 0 for the default.
  [[nodiscard]] double asked_width() const { return asked_width_; }

 private:
  /// The filter's shape at t = |offset| / (width / 2), 0 ≤ t ≤ 1, not normalised.
  [[nodiscard]] double shape(double t) const;
  [[nodiscard]] float sample1(float u) const;
  void tabulate();

  FilterKind kind_;
  double asked_width_;
  double width_;
  float half_width_;
  double norm_ = 1;  ///< density(0) / shape(0)
  // t as a function of the part of the distribution that lies beyond it, 1 … 2^-24. Each octave of
  // that part is cut into 32 cells, so the thin edge of a filter is cut as finely as its middle,
  // and the part's bits as a float are the number of its cell and the place in it. Each cell has
  // the coefficients of a cubic; the distribution is met to 1e-6.
  static constexpr std::uint32_t one = std::bit_cast<std::uint32_t>(1.0F);
  static constexpr std::uint32_t cell_bits = 23 - 5;
  static constexpr std::uint32_t cells = 24 << 5;
  static constexpr float least_part = 0x1p-24F;  ///< what u = 0 counts as: half of the next u
  std::array<std::array<float, 4>, cells + 1> table_{};
};

}  // namespace tessera::render
