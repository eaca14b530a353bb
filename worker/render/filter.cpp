#include "worker/render/filter.hpp"

#include <algorithm>
#include <cmath>

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
    : kind_(kind), width_(width > 0 ? width : default_width(kind)) {
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

void Filter::tabulate() {
  for (int i = 0; i <= segments; ++i) {
    shape_[static_cast<std::size_t>(i)] = shape(static_cast<double>(i) / segments);
  }
  // The shape is taken as linear between the places, which is true of it to 2e-6; its integral is
  // then exact.
  cdf_[0] = 0;
  for (std::size_t i = 0; i < segments; ++i) {
    cdf_[i + 1] = cdf_[i] + 0.5 * (shape_[i] + shape_[i + 1]);
  }
  const double total = cdf_[segments];
  norm_ = segments / (total * width_);
  for (std::size_t i = 0; i <= segments; ++i) {
    cdf_[i] /= total;
    shape_[i] /= total;
  }
  std::size_t segment = 0;
  for (std::size_t i = 0; i < segments; ++i) {
    while (segment + 1 < segments && cdf_[segment + 1] <= static_cast<double>(i) / segments) {
      ++segment;
    }
    guide_[i] = static_cast<std::uint16_t>(segment);
  }
}

float Filter::sample1(float u) const {
  const double signed_u = 2 * static_cast<double>(u) - 1;
  const double v = std::abs(signed_u);
  double t = 1;
  switch (kind_) {
    case FilterKind::box:
      t = v;
      break;
    case FilterKind::tent:
      t = 1 - std::sqrt(1 - v);
      break;
    case FilterKind::gaussian:
    case FilterKind::blackman_harris: {
      std::size_t i = guide_[static_cast<std::size_t>(std::min(v * segments, segments - 1.0))];
      while (i + 1 < segments && cdf_[i + 1] <= v) ++i;
      // Within the segment the density is linear, so the distribution is a parabola: its root, in
      // the form that does not cancel.
      const double rest = v - cdf_[i];
      const double slope = shape_[i + 1] - shape_[i];
      const double root = std::sqrt(std::max(0.0, shape_[i] * shape_[i] + 2 * slope * rest));
      t = (static_cast<double>(i) + std::min(1.0, 2 * rest / (shape_[i] + root))) / segments;
      break;
    }
  }
  return static_cast<float>(std::copysign(0.5 * width_ * t, signed_u));
}

}  // namespace tessera::render
