#pragma once
#include "worker/render/lights/light.hpp"

namespace tessera::render {

/// Some lights as one: what a tree is built from. Where they are, in which directions they shine,
/// and how strongly.
struct LightCluster {
  Bounds3 bounds;
  /// Unit. Within `theta_o` of it lie the axes of all of them, and `theta_e` further each ends.
  Vec3d axis{0, 0, 1};
  double theta_o = 0, theta_e = 0;  ///< radians
  double intensity = 0;             ///< the sum of their greatest

  LightCluster() = default;
  explicit LightCluster(const Light& light);

  /// Takes in what shines in the directions of `other`, too. Conty and Kulla, "Importance Sampling
  /// of Many Lights with Adaptive Tree Splitting", 2018.
  void grow_cone(const LightCluster& other);
  void grow(const LightCluster& other);

  /// The share of all directions, weighed by how much comes there: the orientation part of the
  /// surface area orientation heuristic.
  [[nodiscard]] double orientation() const;
};

}  // namespace tessera::render
