#pragma once
#include <array>

#include "common/scene/description.hpp"
#include "worker/render/ray.hpp"
#include "worker/render/vec.hpp"

namespace tessera::render {

/// A pinhole: from a place on the film to a ray. Positions are relative to the scene's origin.
class Camera {
 public:
  Camera(const scene::Camera& camera, int film_width, int film_height,
         const std::array<double, 3>& origin);

  /// The ray through pixel (x, y), `offset` pixels off its centre. x runs to the right, y down;
  /// offsets may lead over edges.
  [[nodiscard]] Ray ray(int x, int y, Vec2 offset, float time) const {
    const double fx = static_cast<double>(x) + 0.5 + static_cast<double>(offset.x);
    const double fy = static_cast<double>(y) + 0.5 + static_cast<double>(offset.y);
    Ray out;
    out.origin = eye_;
    out.direction = to_float(normalize(corner_ + across_ * fx + down_ * fy));
    out.time = time;
    out.cone_spread = spread_;
    return out;
  }
  /// Distance of a point at distance t along `direction` from the plane of the eye: the Z channel.
  [[nodiscard]] float depth(const Vec3& direction, float t) const {
    return dot(direction, forward_) * t;
  }

 private:
  Vec3 eye_, forward_;
  Vec3d corner_, across_, down_;  ///< of the film at distance 1; steps of one pixel
  float spread_ = 0;
};

}  // namespace tessera::render
