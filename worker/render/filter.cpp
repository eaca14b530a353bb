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

void Filter::tabulate() {
  std::array<double, segments + 1> shapes{}, cdf{};
  for (int i = 0; i <= segments; ++i) {
    shapes[static_cast<std::size_t>(i)] = shape(static_cast<double>(i) / segments);
  }
  // The shape is taken as linear between the places, which is true of it to 2e-6; its integral is
  // then exact.
  for (std::size_t i = 0; i < segments; ++i) {
    cdf[i + 1] = cdf[i] + 0.5 * (shapes[i] + shapes[i + 1]);
  }
  const double total = cdf[segments];
  norm_ = segments / (total * width_);
  for (std::size_t i = 0; i < segments; ++i) {
    table_[i] = {.cdf = static_cast<float>(cdf[i] / total),
                 .shape = static_cast<float>(shapes[i] / total),
                 .next_cdf = static_cast<float>(cdf[i + 1] / total),
                 .next_shape = static_cast<float>(shapes[i + 1] / total)};
  }
  std::size_t segment = 0;
  for (std::size_t i = 0; i < segments; ++i) {
    while (segment + 1 < segments &&
           table_[segment].next_cdf <= static_cast<float>(i) / static_cast<float>(segments)) {
      ++segment;
    }
    guide_[i] = static_cast<std::uint16_t>(segment);
  }
}

float Filter::sample1(float u) const {
  const float signed_u = 2 * u - 1;  // exact
  const float v = std::abs(signed_u);
  float t = 1;
  switch (kind_) {
    case FilterKind::box:
      t = v;
      break;
    case FilterKind::tent:
      t = 1 - std::sqrt(1 - v);
      break;
    case FilterKind::gaussian:
    case FilterKind::blackman_harris: {
      std::size_t i = guide_[static_cast<std::size_t>(std::min(v * segments, segments - 1.0F))];
      while (i + 1 < segments && table_[i].next_cdf <= v) ++i;
      const Segment& at = table_[i];
      // Within the segment the density is linear, so the distribution is a parabola: its root, in
      // the form that does not cancel.
      const float rest = v - at.cdf;
      const float slope = at.next_shape - at.shape;
      const float root = std::sqrt(std::max(0.0F, at.shape * at.shape + 2 * slope * rest));
      const float part = 2 * rest / (at.shape + root);
      t = (static_cast<float>(i) + std::min(1.0F, part)) * (1.0F / segments);
      break;
    }
  }
  return std::copysign(half_width_ * t, signed_u);
}

std::shared_ptr<const Filter> shared_filter(FilterKind kind, double width) {
  thread_local std::shared_ptr<const Filter> last;
  if (!last || last->kind() != kind || last->asked_width() != width) {
    last = std::make_shared<const Filter>(kind, width);
  }
  return last;
}

}  // namespace tessera::render
