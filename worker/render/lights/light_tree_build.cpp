#include "worker/render/lights/light_tree_build.hpp"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "worker/render/fastmath.hpp"
#include "worker/render/lights/light_cluster.hpp"

namespace tessera::render {
namespace {

constexpr std::size_t cells = 12;
/// So few are parted in the middle.
constexpr std::size_t few = 4;
/// From this depth on too, so that a way fits 64 bits.
constexpr int deep = 36;
/// More than these are worth a thread.
constexpr std::size_t many = 4096;

struct Item {
  LightCluster cluster;
  std::array<float, 3> center{};
  std::uint32_t light = 0;
};
using Items = std::span<Item>;

std::array<float, 3> center_of(const Bounds3& b) {
  const Vec3 c = (b.low + b.high) * 0.5F;
  return {c.x, c.y, c.z};
}

double diagonal_squared(const Bounds3& b) { return length_squared(to_double(b.high - b.low)); }

/// What lies in one cell, its cone by the mean of its lights' axes: a light's own cone is either
/// one direction or all.
struct Cell {
  LightCluster all;
  Vec3d axes;
  double least = 1;  ///< cosine from the mean axis
  bool everywhere = false;

  void add(const LightCluster& one) {
    all.bounds.grow(one.bounds);
    all.intensity += one.intensity;
    all.theta_e = std::max(all.theta_e, one.theta_e);
    everywhere = everywhere || one.theta_o > 0;
    axes += one.axis;
  }
  void find_axis() {
    all.axis = normalize(axes);
    everywhere = everywhere || !(length_squared(all.axis) > 0);
  }
  void widen(const LightCluster& one) { least = std::min(least, dot(all.axis, one.axis)); }
  void close() { all.theta_o = everywhere ? pi_d : fast::acos(std::clamp(least, -1.0, 1.0)); }
};

struct Range {
  std::array<float, 3> low, high;

  explicit Range(Items items) : low(items[0].center), high(low) {
    for (const Item& item : items) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], item.center[axis]);
        high[axis] = std::max(high[axis], item.center[axis]);
      }
    }
  }
  [[nodiscard]] float extent(std::size_t axis) const { return high[axis] - low[axis]; }
  [[nodiscard]] std::size_t widest() const {
    const std::size_t side = extent(1) > extent(0) ? 1 : 0;
    return extent(2) > extent(side) ? 2 : side;
  }
  [[nodiscard]] std::size_t cell_of(const Item& item, std::size_t axis) const {
    const float part = (item.center[axis] - low[axis]) / extent(axis);
    return std::min(static_cast<std::size_t>(part * static_cast<float>(cells)), cells - 1);
  }
};

/// A plane between two cells, and what it costs to part there.
struct Plane {
  std::size_t axis = 0;
  std::size_t before = 0;  ///< cells below it; 0: there is none
  double cost = 0;
};

double cost_of(const LightCluster& side) {
  return side.intensity * side.orientation() * diagonal_squared(side.bounds);
}

std::array<Cell, cells> cells_along(Items items, const Range& range, std::size_t axis) {
  std::array<Cell, cells> out;
  for (const Item& item : items) out[range.cell_of(item, axis)].add(item.cluster);
  for (Cell& cell : out) cell.find_axis();
  for (const Item& item : items) out[range.cell_of(item, axis)].widen(item.cluster);
  for (Cell& cell : out) cell.close();
  return out;
}

void look_along(Items items, const Range& range, std::size_t axis, Plane& best) {
  const std::array<Cell, cells> along = cells_along(items, range, axis);
  std::array<double, cells> behind{};
  LightCluster above;
  for (std::size_t i = cells - 1; i > 0; --i) {
    if (along[i].all.intensity > 0) above.grow(along[i].all);
    behind[i] = above.intensity > 0 ? cost_of(above) : -1;
  }
  // Thin slices are dear: that keeps clusters from becoming flat.
  const double slender =
      static_cast<double>(range.extent(range.widest())) / static_cast<double>(range.extent(axis));
  LightCluster below;
  for (std::size_t i = 1; i < cells; ++i) {
    if (along[i - 1].all.intensity > 0) below.grow(along[i - 1].all);
    if (!(below.intensity > 0) || behind[i] < 0) continue;
    const double cost = slender * (cost_of(below) + behind[i]);
    if (best.before == 0 || cost < best.cost) best = {axis, i, cost};
  }
}

/// Parts the items in two; how many are in the first.
std::size_t part(Items items, int depth) {
  const Range range(items);
  Plane best;
  if (items.size() > few && depth < deep) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (range.extent(axis) > 0) look_along(items, range, axis, best);
    }
  }
  if (best.before > 0) {
    const auto middle = std::partition(items.begin(), items.end(), [&](const Item& item) {
      return range.cell_of(item, best.axis) < best.before;
    });
    return static_cast<std::size_t>(middle - items.begin());
  }
  const std::size_t axis = range.widest(), half = items.size() / 2;
  std::nth_element(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(half), items.end(),
                   [&](const Item& a, const Item& b) {
                     return a.center[axis] != b.center[axis] ? a.center[axis] < b.center[axis]
                                                             : a.light < b.light;
                   });
  return half;
}

class Builder {
 public:
  explicit Builder(std::span<const Light> lights) {
    out_.ways.resize(lights.size());
    for (std::uint32_t i = 0; i < lights.size(); ++i) {
      Item item{LightCluster(lights[i]), {}, i};
      if (!(item.cluster.intensity > 0) || item.cluster.bounds.empty()) continue;
      item.center = center_of(item.cluster.bounds);
      items_.push_back(item);
      brightest_ = std::max(brightest_, item.cluster.intensity);
    }
    if (items_.empty()) return;
    out_.nodes.resize(2 * items_.size() - 1);
    build(items_, {.node = 0, .below = 1, .way = 0, .depth = 0});
  }
  BuiltLightTree take() { return std::move(out_); }

 private:
  struct Place {
    std::size_t node, below;  ///< where it stands, and all that is under it
    std::uint64_t way;
    int depth;
  };

  LightCluster build(Items items, const Place& at) {
    if (items.size() == 1) {
      out_.ways[items[0].light] = at.way;
      write(items[0].cluster, at.node, items[0].light, true);
      return items[0].cluster;
    }
    const std::size_t parted = part(items, at.depth);
    // The two stand together; under them, all of the first before all of the second.
    const Place first{at.below, at.below + 2, at.way, at.depth + 1};
    const Place second{at.below + 1, at.below + 2 * parted,
                       at.way | (std::uint64_t{1} << static_cast<unsigned>(at.depth)),
                       at.depth + 1};
    LightCluster both, more;
    const auto build_first = [&] { both = build(items.first(parted), first); };
    const auto build_second = [&] { more = build(items.subspan(parted), second); };
    if (items.size() > many) {
      tbb::parallel_invoke(build_first, build_second);
    } else {
      build_first();
      build_second();
    }
    both.grow(more);
    write(both, at.node, static_cast<std::uint32_t>(at.below), false);
    return both;
  }

  void write(const LightCluster& cluster, std::size_t index, std::uint32_t next, bool leaf) {
    // What the floats round away of a cone that several share.
    const double slack = leaf ? 0 : 1e-6;
    const double theta_o = std::min(cluster.theta_o + slack, pi_d);
    LightNode& node = out_.nodes[index];
    const Vec3 half = (cluster.bounds.high - cluster.bounds.low) * 0.5F;
    node.center = cluster.bounds.low + half;
    // What rounding took from it, so that the box holds its corners.
    const auto reach = [](float side, float at) { return side + (side + std::abs(at)) * 0x1p-22F; };
    node.half = {reach(half.x, node.center.x), reach(half.y, node.center.y),
                 reach(half.z, node.center.z)};
    node.radius = length(node.half);
    node.axis = to_float(cluster.axis);
    const auto [sine, cosine] = fast::sincos(theta_o);
    node.cos_o = theta_o >= pi_d ? -1.0F : static_cast<float>(cosine);
    node.sin_o = static_cast<float>(sine);
    node.cos_e = static_cast<float>(fast::sincos(cluster.theta_e).second);
    node.intensity = static_cast<float>(cluster.intensity / brightest_);
    node.next = next;
    node.leaf = leaf;
  }

  BuiltLightTree out_;
  std::vector<Item> items_;
  double brightest_ = 0;
};

}  // namespace

BuiltLightTree build_light_tree(std::span<const Light> lights) { return Builder(lights).take(); }

}  // namespace tessera::render
