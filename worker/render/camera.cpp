#include "worker/render/camera.hpp"

#include <algorithm>
#include <cmath>

#include "worker/render/fastmath.hpp"
#include "worker/render/warp.hpp"

namespace tessera::render {

Camera::Camera(const scene::Camera& camera, int film_width, int film_height,
               const std::array<double, 3>& origin, double pixel_aspect) {
  const Vec3d eye = to_vec3d(camera.eye);
  eye_ = eye - to_vec3d(origin);
  forward_ = normalize(to_vec3d(camera.target) - eye);
  right_ = normalize(cross(forward_, to_vec3d(camera.up)));
  up_ = cross(right_, forward_);
  if (camera.projection == scene::Projection::equirectangular) {
    frame_sphere(film_width, film_height);
  } else {
    radius_ = camera.lens.radius;
    focus_ = camera.lens.focus_distance;
    blades_ = camera.lens.blades;
    rotation_ = camera.lens.rotation_degrees * (pi_d / 180);
    frame_film(camera, film_width, film_height, pixel_aspect);
  }
}

void Camera::frame_film(const scene::Camera& camera, int film_width, int film_height,
                        double pixel_aspect) {
  const auto [sine, cosine] = fast::sincos(camera.fov_y_degrees * (pi_d / 360));
  const bool parallel = camera.projection == scene::Projection::orthographic;
  double half_height = parallel ? camera.orthographic_height / 2 : sine / cosine;
  half_height *= std::max(1.0, camera.least_aspect * film_height / (film_width * pixel_aspect));
  const double step = 2 * half_height / film_height;
  across_ = right_ * (step * pixel_aspect);
  down_ = up_ * -step;
  corner_ = (parallel ? eye_ : forward_) - across_ * ((0.5 - camera.shift[0]) * film_width) -
            down_ * ((0.5 + camera.shift[1]) * film_height);
  (parallel ? width_ : spread_) = static_cast<float>(step * std::min(1.0, pixel_aspect));
  optics_ = parallel ? Optics::parallel : radius_ > 0 ? Optics::lens : Optics::pinhole;
}

void Camera::frame_sphere(int film_width, int film_height) {
  optics_ = Optics::sphere;
  across_ = {2 * pi_d / film_width, 0, 0};
  down_ = {0, -pi_d / film_height, 0};
  corner_ = {-pi_d, pi_d / 2, 0};
  spread_ = static_cast<float>(pi_d / film_height);
}

void Camera::bend(double fx, double fy, Vec2 lens, Ray& out) const {
  const Vec3d place = corner_ + across_ * fx + down_ * fy;
  if (optics_ == Optics::sphere) {
    const auto [sin_longitude, cos_longitude] = fast::sincos(place.x);
    const auto [sin_latitude, cos_latitude] = fast::sincos(place.y);
    out.origin = to_float(eye_);
    out.direction = to_float(normalize(
        (forward_ * cos_longitude + right_ * sin_longitude) * cos_latitude + up_ * sin_latitude));
    return;
  }
  const Vec2 point = on_aperture(lens);
  const Vec3d aside = right_ * (radius_ * static_cast<double>(point.x)) +
                      up_ * (radius_ * static_cast<double>(point.y));
  const bool parallel = optics_ == Optics::parallel;
  out.origin = to_float((parallel ? place : eye_) + aside);
  out.direction = to_float(normalize((parallel ? forward_ : place) * focus_ - aside));
}

Vec2 Camera::on_aperture(Vec2 lens) const {
  if (blades_ == 0) return square_to_disk(lens);
  // One of the triangles between the middle and two corners, and a place in it.
  const double scaled = static_cast<double>(lens.x) * blades_;
  const double blade = std::min(std::floor(scaled), blades_ - 1.0);
  const Vec2 in = square_to_triangle({static_cast<float>(scaled - blade), lens.y});
  const double step = 2 * pi_d / blades_;
  const auto [sin_a, cos_a] = fast::sincos(rotation_ + blade * step);
  const auto [sin_b, cos_b] = fast::sincos(rotation_ + (blade + 1) * step);
  return {in.x * static_cast<float>(cos_a) + in.y * static_cast<float>(cos_b),
          in.x * static_cast<float>(sin_a) + in.y * static_cast<float>(sin_b)};
}

}  // namespace tessera::render
