#pragma once
#include <array>

#include "common/scene/description.hpp"
#include "worker/render/ray.hpp"
#include "worker/render/vec.hpp"

namespace tessera::render {

/// From a place on the film to a ray. Where a film shows all directions the aspect of its pixels
/// says nothing. Positions are relative to the scene's origin.
class Camera {
 public:
  Camera(const scene::Camera& camera, int film_width, int film_height,
         const std::array<double, 3>& origin, double pixel_aspect = 1);

  /// The ray through pixel (x, y), `offset` pixels off its centre, and through the point of the
  /// aperture that `lens`, in [0, 1)², stands for. x runs to the right, y down; offsets may lead
  /// over edges.
  [[nodiscard]] Ray ray(int x, int y, Vec2 offset, Vec2 lens, float time) const {
    const double fx = static_cast<double>(x) + 0.5 + static_cast<double>(offset.x);
    const double fy = static_cast<double>(y) + 0.5 + static_cast<double>(offset.y);
    Ray out;
    out.time = time;
    out.cone_width = width_;
    out.cone_spread = spread_;
    if (optics_ == Optics::pinhole) {
      out.origin = to_float(eye_);
      out.direction = to_float(normalize(corner_ + across_ * fx + down_ * fy));
    } else {
      bend(fx, fy, lens, out);
    }
    return out;
  }
  /// Distance of a point at distance t along `direction` from the plane of the eye, or, where the
  /// camera looks in all directions, from the eye: the Z channel.
  [[nodiscard]] float depth(const Vec3& direction, float t) const {
    return optics_ == Optics::sphere ? t : dot(direction, to_float(forward_)) * t;
  }

 private:
  enum class Optics { pinhole, lens, parallel, sphere };

  void frame_film(const scene::Camera& camera, int film_width, int film_height,
                  double pixel_aspect);
  void frame_sphere(int film_width, int film_height);
  /// All but the pinhole's: origin and direction of the ray through a place of the film.
  void bend(double fx, double fy, Vec2 lens, Ray& out) const;
  /// On the aperture, in units of its radius: x to the right, y up.
  [[nodiscard]] Vec2 on_aperture(Vec2 lens) const;

  Optics optics_ = Optics::pinhole;
  Vec3d eye_, right_, up_, forward_;
  /// Of the film at distance 1, as seen from the eye, or through the eye; steps of one pixel. Of
  /// the sphere: longitude and latitude in x and y, radians.
  Vec3d corner_, across_, down_;
  double radius_ = 0, focus_ = 1, rotation_ = 0;  ///< radians
  int blades_ = 0;
  float spread_ = 0,
        width_ = 0;  ///< of a ray's cone: what it gains over a distance of 1; where it begins
};

}  // namespace tessera::render
