#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "worker/render/lights/light.hpp"

namespace tessera::render {

/// A cluster of lights in the form that is asked from a point: a leaf is one light.
struct LightNode {
  /// Of the box that holds all of it: its middle, and the way from there to a corner.
  Vec3 center, half;
  float radius = 0;             ///< the length of that way
  Vec3 axis{0, 0, 1};           ///< unit
  float cos_o = -1, sin_o = 0;  ///< of the angle around the axis that holds all lights' axes
  float cos_e = 0;              ///< of the angle beyond that at which emission ends
  float intensity = 0;          ///< against the brightest light of the tree
  std::uint32_t next = 0;  ///< the first of two nodes that stand together; of a leaf, the light
  bool leaf = false;

  /// About what irradiance a surface at the context has of it, were nothing between: never 0 where
  /// some of it may shine, but for what rounding makes of an edge.
  [[nodiscard]] double importance(const LightContext& context) const;
};

/// All lights that are somewhere, and the choice among them by what they do at a point: a tree over
/// position, emission cone and intensity, descended by the importance of its nodes. Conty and
/// Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting", 2018; angles of
/// emission are bounded as in pbrt-v4 (lights.h, LightBounds), cosines by the box, and the
/// intensity is the greatest of any direction instead of the power. What is nowhere or gives
/// nothing is never chosen. The bits do not depend on threads.
class LightTree {
 public:
  LightTree() = default;
  /// Builds with the threads of the calling TBB arena.
  explicit LightTree(std::span<const Light> lights);

  struct Pick {
    std::uint32_t light = no_id;
    float pmf = 0;  ///< 0: nothing here gives light there
  };
  /// `u` is uniform in [0, 1), with 32 bits or more.
  [[nodiscard]] Pick pick(const LightContext& context, double u) const;
  /// The probability with which pick() gives this light.
  [[nodiscard]] float pmf(const LightContext& context, std::uint32_t light) const;
  /// False if pick() gives nothing.
  [[nodiscard]] bool reaches(const LightContext& context) const;
  [[nodiscard]] bool empty() const { return nodes_.empty(); }

 private:
  std::vector<LightNode> nodes_;  ///< 0 is the root
  /// Of each light: the way to its leaf, the root's turn in bit 0; 1 is to the second of two. What
  /// is not in the tree has a way that leads to another.
  std::vector<std::uint64_t> ways_;
};

}  // namespace tessera::render
