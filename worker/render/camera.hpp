#pragma once
#include <array>

#include "common/scene/description.hpp"
#include "worker/render/ray.hpp"
#include "worker/render/vec.hpp"

namespace tessera::render {

/// A pinhole, or rays alongside each other: from a place on the film to a ray. Positions are
/// relative to the scene's origin.
class Camera {
 public:
  Camera(const scene::Camera& camera, int film_width, int film_height,
         const std::array<double, 3>& origin);

  /// The ray through pixel (x, y), `offset` pixels off its centre. x runs to the right, y down;
  /// offsets may lead over edges.
  [[nodiscard]] Ray ray(int x, int y, Vec2 offset, float time) const {
    const double fx = static_cast<double>(x) + 0.5 + static_cast<double>(offset.x);
    const double fy = static_cast<double>(y) + 0.5 + static_cast<double>(offset.y);
    const Vec3d place = corner_ + across_ * fx + down_ * fy;
    Ray out;
    out.origin = orthographic_ ? to_float(place) : eye_;
    out.direction = orthographic_ ? forward_ : to_float(normalize(place));
    out.time = time;
    out.cone_width = width_;
    out.cone_spread = spread_;
    return out;
  }
  /// Distance of a point at distance t along `direction` from the plane of the eye: the Z channel.
  [[nodiscard]] float depth(const Vec3& direction, float t) const {
    return dot(direction, forward_) * t;
  }

 private:
  Vec3 eye_, forward_;
  /// Of the film at distance 1, as seen from the eye, or through the eye; steps of one pixel.
  Vec3d corner_, across_, down_;
  float spread_ = 0,
        width_ = 0;  ///< of a ray's cone: what it gains over a distance of 1; where it begins
  bool orthographic_ = false;
};

}  // namespace tessera::render
