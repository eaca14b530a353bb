#include "worker/render/filter.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "worker/render/fastmath.hpp"

namespace tessera::render {

namespace {

struct Entry {
  std::string_view name;
  FilterKind kind;
  double default_width;  ///< pixels, edge to edge
};
/// Every filter there is. The next one: a kind, its shape, a line here.
constexpr Entry filters[] = {
    {"box", FilterKind::box, 1},
    {"tent", FilterKind::tent, 2},
    {"gaussian", FilterKind::gaussian, 3},
    {"blackman_harris", FilterKind::blackman_harris, 3},
};

double default_width(FilterKind kind) {
  for (const Entry& entry : filters) {
    if (entry.kind == kind) return entry.default_width;
  }
  return 1;
}

}  // namespace

FilterKind filter_kind(std::string_view name) {
  for (const Entry& entry : filters) {
    if (entry.name == name) return entry.kind;
  }
  throw Error(ErrorKind::bad_input, unknown_name("filter", name, filter_names()));
}

std::vector<std::string_view> filter_names() {
  std::vector<std::string_view> names;
  for (const Entry& entry : filters) names.push_back(entry.name);
  return names;
}

Filter::Filter(FilterKind kind, double width)
    : kind_(kind),
      asked_width_(width),
      width_(width > 0 ? width : default_width(kind)),
      half_width_(static_cast<float>(0.5 * width_)) {
  tabulate();
}

double Filter::shape(double t) const {
  switch (kind_) {
    case FilterKind::box:
      return 1;
    case FilterKind::tent:
      return 1 - t;
    case FilterKind::gaussian:
      return fast::exp(-4.5 * t * t);  // three σ at the edge
    case FilterKind::blackman_harris:
      // Harris, "On the use of windows for harmonic analysis with the discrete Fourier transform",
      // 1978: 4 terms, −92 dB.
      return 0.35875 + 0.48829 * fast::cos(pi_d * t) + 0.14128 * fast::cos(2 * pi_d * t) +
             0.01168 * fast::cos(3 * pi_d * t);
  }
  return 0;
}

double Filter::density(double offset) const {
  const double t = 2 * std::abs(offset) / width_;
  return t <= 1 ? shape(t) * norm_ : 0;
}

namespace {

/// The inverse of what is left of a distribution beyond t, 0 ≤ t ≤ 1, whose density is linear
/// between evenly spaced values. Asked for falling parts, from 1 on.
class Tail {
 public:
  explicit Tail(std::span<const double> densities) : density_(densities), left_(densities.size()) {
    for (std::size_t i = density_.size() - 1; i > 0; --i) {
      left_[i - 1] = left_[i] + 0.5 * step_ * (density_[i - 1] + density_[i]);
    }
  }
  [[nodiscard]] double whole() const { return left_[0]; }

  struct Place {
    double t, density;
  };
  /// Where `part` of the whole is left.
  Place at(double part) {
    const double left = part * whole();
    while (segment_ + 2 < density_.size() && left_[segment_ + 1] >= left) ++segment_;
    // Within the segment the distribution is a parabola: its root, in the form that does not
    // cancel.
    const double passed = (left_[segment_] - left) / step_;
    const double first = density_[segment_], slope = density_[segment_ + 1] - first;
    const double density = std::sqrt(std::max(0.0, first * first + 2 * slope * passed));
    const double beyond = passed > 0 ? 2 * passed / (first + density) : 0;
    return {(static_cast<double>(segment_) + beyond) * step_, density};
  }

 private:
  std::span<const double> density_;
  std::vector<double> left_;
  double step_ = 1 / static_cast<double>(density_.size() - 1);
  std::size_t segment_ = 0;
};

}  // namespace

void Filter::tabulate() {
  constexpr std::size_t segments = 1024;
  // The shape is taken as linear between the places, which is true of it to 2e-6; its integral is
  // then exact.
  std::vector<double> shapes(segments + 1);
  for (std::size_t i = 0; i <= segments; ++i) shapes[i] = shape(static_cast<double>(i) / segments);
  Tail tail(shapes);
  norm_ = 1 / (tail.whole() * width_);
  const auto part_from = [](std::uint32_t cell) {
    return static_cast<double>(std::bit_cast<float>(one - (cell << cell_bits)));
  };
  Tail::Place from = tail.at(1);
  for (std::uint32_t i = 0; i < cells; ++i) {
    const Tail::Place to = tail.at(part_from(i + 1));
    // The cubic with the right values and slopes at both ends (Hermite).
    const double part = (part_from(i) - part_from(i + 1)) * tail.whole();
    const double rise = to.t - from.t, slope0 = part / from.density, slope1 = part / to.density;
    table_[i] = {static_cast<float>(from.t), static_cast<float>(slope0),
                 static_cast<float>(3 * rise - 2 * slope0 - slope1),
                 static_cast<float>(slope0 + slope1 - 2 * rise)};
    from = to;
  }
  table_[cells] = {static_cast<float>(from.t), 0, 0, 0};
}

float Filter::sample1(float u) const {
  const float signed_u = 2 * u - 1;  // exact, as is what lies beyond
  const float beyond = std::max(1 - std::abs(signed_u), least_part);
  const std::uint32_t place = one - std::bit_cast<std::uint32_t>(beyond);
  const std::array<float, 4>& c = table_[place >> cell_bits];
  const float x = static_cast<float>(place % (1U << cell_bits)) * (1.0F / (1U << cell_bits));
  const float t = c[0] + x * (c[1] + x * (c[2] + x * c[3]));
  return std::copysign(half_width_ * std::min(t, 1.0F), signed_u);
}

std::shared_ptr<const Filter> shared_filter(FilterKind kind, double width) {
  thread_local std::shared_ptr<const Filter> last;
  if (!last || last->kind() != kind || last->asked_width() != width) {
    last = std::make_shared<const Filter>(kind, width);
  }
  return last;
}

}  // namespace tessera::render
