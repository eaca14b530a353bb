#include "worker/render/camera.hpp"

#include "worker/render/fastmath.hpp"

namespace tessera::render {

Camera::Camera(const scene::Camera& camera, int film_width, int film_height,
               const std::array<double, 3>& origin) {
  const Vec3d eye = to_vec3d(camera.eye);
  const Vec3d forward = normalize(to_vec3d(camera.target) - eye);
  const Vec3d right = normalize(cross(forward, to_vec3d(camera.up)));
  const Vec3d up = cross(right, forward);
  const auto [sine, cosine] = fast::sincos(camera.fov_y_degrees * (pi_d / 360));
  orthographic_ = camera.orthographic_height > 0;
  const double half_height = orthographic_ ? camera.orthographic_height / 2 : sine / cosine;
  const double step = 2 * half_height / film_height;
  const Vec3d at = eye - to_vec3d(origin);
  eye_ = to_float(at);
  forward_ = to_float(forward);
  across_ = right * step;
  down_ = up * -step;
  corner_ =
      (orthographic_ ? at : forward) - across_ * (0.5 * film_width) - down_ * (0.5 * film_height);
  (orthographic_ ? width_ : spread_) = static_cast<float>(step);
}

}  // namespace tessera::render
