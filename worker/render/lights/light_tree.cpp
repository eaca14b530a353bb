#include "worker/render/lights/light_tree.hpp"

#include <algorithm>
#include <cmath>

#include "worker/render/lights/light_tree_build.hpp"

namespace tessera::render {
namespace {

/// An angle of 0 … π by its cosine and sine.
struct Angle {
  float cos, sin;

  static Angle of(float cosine) {
    const float c = std::clamp(cosine, -1.0F, 1.0F);
    return {c, std::sqrt((1 - c) * (1 + c))};
  }
  /// The cosine of what is left of it after `taken`; 1 where that is more.
  [[nodiscard]] Angle less(const Angle& taken) const {
    if (cos >= taken.cos) return {1, 0};
    return {cos * taken.cos + sin * taken.sin, sin * taken.cos - cos * taken.sin};
  }
};

/// A cosine this small is that of a right angle.
constexpr float right_angle = 1e-6F;

Vec3 absolute(const Vec3& v) { return {std::abs(v.x), std::abs(v.y), std::abs(v.z)}; }

/// No smaller than the cosine between `n` and the way to any point of the box at `way`; `nearest`
/// is how far its nearest point is. Not above 0 only if all of it is on the other side. Unlike the
/// angle of a sphere around the box it tells a wide, low box at the horizon from one overhead.
float most_cosine(const Vec3& n, const Vec3& way, const Vec3& half, float nearest) {
  const float highest = dot(n, way) + dot(absolute(n), half);
  return highest < nearest ? highest / nearest : 1;
}

/// How often the first of two nodes is taken; negative where neither gives anything.
double share_of_first(const LightNode* two, const LightContext& context) {
  const double first = two[0].importance(context), second = two[1].importance(context);
  const double sum = first + second;
  return sum > 0 ? first / sum : -1;
}

}  // namespace

double LightNode::importance(const LightContext& context) const {
  const Vec3 way = center - context.p;
  const float distance2 = length_squared(way), radius2 = radius * radius;
  const float farther2 = std::max(distance2, radius2);
  // A light that is where the point is gives nothing.
  if (!(farther2 > 0)) return 0;
  // To the nearest point of the box.
  const float nearest = length(Vec3{std::max(std::abs(way.x) - half.x, 0.0F),
                                    std::max(std::abs(way.y) - half.y, 0.0F),
                                    std::max(std::abs(way.z) - half.z, 0.0F)});
  float cosine = 1;
  if (!(context.n == Vec3{})) {
    cosine = most_cosine(context.n, way, half, nearest);
    if (!(cosine > 0)) return 0;
  }
  if (cos_o == 1 && cos_e < right_angle) {
    // All turned one way, and their light falls off with the cosine.
    const float sent = most_cosine(axis, -way, half, nearest);
    if (!(sent > 0)) return 0;
    cosine *= sent;
  } else if (cos_o > -1 && distance2 > radius2) {
    const float inverse = 1 / std::sqrt(distance2);
    const Angle seen{std::sqrt(1 - radius2 / distance2), radius * inverse};
    const Angle off = Angle::of(-dot(way, axis) * inverse).less({cos_o, sin_o}).less(seen);
    if (!(off.cos > cos_e)) return 0;
    cosine *= off.cos;
  }
  return static_cast<double>(intensity) * static_cast<double>(cosine) /
         static_cast<double>(farther2);
}

LightTree::LightTree(std::span<const Light> lights) {
  BuiltLightTree built = build_light_tree(lights);
  nodes_ = std::move(built.nodes);
  ways_ = std::move(built.ways);
}

LightTree::Pick LightTree::pick(const LightContext& context, double u) const {
  if (nodes_.empty()) return {};
  const LightNode* node = nodes_.data();
  double pmf = 1;
  while (!node->leaf) {
    const LightNode* const two = &nodes_[node->next];
    const double first = share_of_first(two, context);
    if (first < 0) return {};
    if (u < first) {
      node = two;
      u /= first;
      pmf *= first;
    } else {
      node = two + 1;
      u = std::min((u - first) / (1 - first), 1 - 0x1p-53);
      pmf *= 1 - first;
    }
  }
  return {.light = node->next, .pmf = static_cast<float>(pmf)};
}

float LightTree::pmf(const LightContext& context, std::uint32_t light) const {
  if (nodes_.empty()) return 0;
  const LightNode* node = nodes_.data();
  double pmf = 1;
  for (std::uint64_t way = ways_[light]; !node->leaf; way >>= 1U) {
    const LightNode* const two = &nodes_[node->next];
    const double first = share_of_first(two, context);
    if (first < 0) return 0;
    const bool second = (way & 1U) != 0;
    node = second ? two + 1 : two;
    pmf *= second ? 1 - first : first;
  }
  return node->next == light ? static_cast<float>(pmf) : 0;
}

bool LightTree::reaches(const LightContext& context) const {
  return !nodes_.empty() && nodes_[0].importance(context) > 0;
}

}  // namespace tessera::render
