#include "worker/render/camera.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace tessera::render {
namespace {

constexpr std::array<double, 3> no_origin{0, 0, 0};

/// Looks along −z from (0, 0, 5).
scene::Camera camera_of(scene::Projection projection) {
  scene::Camera camera;
  camera.projection = projection;
  camera.orthographic_height = 3;
  return camera;
}

void for_each_lens(const std::function<void(Vec2)>& see) {
  constexpr int side = 96;  // a whole number for every blade
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x)
      see({(static_cast<float>(x) + 0.5F) / side, (static_cast<float>(y) + 0.5F) / side});
}

void expect_near(const Vec3& a, const Vec3& b, float tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

Vec3 at_depth(const Ray& ray, float z) {
  return ray.origin + ray.direction * ((z - ray.origin.z) / ray.direction.z);
}

TEST(Camera, RaysOfOnePlaceOfTheFilmMeetInThePlaneOfFocus) {
  for (const auto projection : {scene::Projection::perspective, scene::Projection::orthographic}) {
    scene::Camera camera = camera_of(projection);
    const Ray pinhole = Camera(camera, 30, 20, no_origin).ray(3, 4, {0.2F, 0.1F}, {}, 0);
    camera.lens = {.radius = 0.7, .focus_distance = 3.5};
    const Camera lens(camera, 30, 20, no_origin);
    double farthest = 0;
    for_each_lens([&](Vec2 u) {
      const Ray ray = lens.ray(3, 4, {0.2F, 0.1F}, u, 0);
      EXPECT_FLOAT_EQ(ray.origin.z, 5);
      expect_near(at_depth(ray, 1.5F), at_depth(pinhole, 1.5F), 2e-6F);
      farthest =
          std::max(farthest, static_cast<double>(length(at_depth(ray, 5) - at_depth(pinhole, 5))));
    });
    EXPECT_NEAR(farthest, 0.7, 0.02);
  }
}

TEST(Camera, ApertureIsADiskOrAPolygonFilledEvenly) {
  scene::Camera camera = camera_of(scene::Projection::perspective);
  for (const int blades : {0, 3, 6}) {
    camera.lens = {.radius = 2, .focus_distance = 1, .blades = blades, .rotation_degrees = 20};
    const Camera lens(camera, 2, 2, no_origin);
    double x = 0, y = 0, square = 0, count = 0;
    for_each_lens([&](Vec2 u) {
      const Ray ray = lens.ray(0, 0, {}, u, 0);
      const double px = static_cast<double>(ray.origin.x) / 2,
                   py = static_cast<double>(ray.origin.y) / 2;
      x += px, y += py, square += px * px + py * py, ++count;
      if (blades == 0) return;
      // Within every edge: the angle to the nearest edge's middle.
      const double step = 2 * pi_d / blades;
      const double angle = std::remainder(std::atan2(py, px) - 20 * pi_d / 180 - step / 2, step);
      EXPECT_LE(std::hypot(px, py) * std::cos(angle), std::cos(step / 2) + 1e-6);
    });
    EXPECT_NEAR(x / count, 0, 1e-3);
    EXPECT_NEAR(y / count, 0, 1e-3);
    // Of a regular polygon with corners at distance 1: the mean of r² is (2 + cos(2π/n))/6.
    const double expected = blades == 0 ? 0.5 : (2 + std::cos(2 * pi_d / blades)) / 6;
    EXPECT_NEAR(square / count, expected, 1e-3) << blades;
  }
}

TEST(Camera, ShiftShowsWhatAWiderFilmHasAside) {
  for (const auto projection : {scene::Projection::perspective, scene::Projection::orthographic}) {
    scene::Camera camera = camera_of(projection);
    const Ray wide = Camera(camera, 40, 20, no_origin).ray(30, 5, {}, {}, 0);
    camera.shift = {0.25, 0.5};
    const Ray shifted = Camera(camera, 40, 20, no_origin).ray(20, 15, {}, {}, 0);
    expect_near(shifted.origin, wide.origin, 1e-6F);
    expect_near(shifted.direction, wide.direction, 1e-6F);
  }
}

TEST(Camera, PixelsOfAnAspectShowAsMuchAsSoManyMoreSquareOnes) {
  for (const auto projection : {scene::Projection::perspective, scene::Projection::orthographic}) {
    scene::Camera camera = camera_of(projection);
    camera.shift = {0.25, 0.5};
    const Ray square = Camera(camera, 40, 20, no_origin).ray(31, 5, {-0.5F, 0}, {}, 0);
    const Ray wide = Camera(camera, 20, 20, no_origin, 2).ray(15, 5, {}, {}, 0);
    expect_near(wide.origin, square.origin, 1e-6F);
    expect_near(wide.direction, square.direction, 1e-6F);
  }
}

TEST(Camera, FilmNarrowerThanItsLeastShapeShowsAsMuchAtItsSides) {
  for (const auto projection : {scene::Projection::perspective, scene::Projection::orthographic}) {
    scene::Camera camera = camera_of(projection);
    camera.least_aspect = 2;
    const Ray fitted = Camera(camera, 40, 20, no_origin).ray(0, 10, {-0.5F, -0.5F}, {}, 0);
    const Ray narrow = Camera(camera, 10, 20, no_origin).ray(0, 10, {-0.5F, -0.5F}, {}, 0);
    const Ray wide = Camera(camera, 80, 20, no_origin).ray(20, 10, {-0.5F, -0.5F}, {}, 0);
    for (const Ray& other : {narrow, wide}) {
      expect_near(other.origin, fitted.origin, 1e-6F);
      expect_near(other.direction, fitted.direction, 1e-6F);
    }
  }
}

TEST(Camera, EquirectangularPictureLiesAsAnEnvironmentsPictureDoes) {
  // Seen along +x: u = 1/2 − atan2(−z, x)/2π from the left, v = acos(y)/π from the top.
  scene::Camera camera = camera_of(scene::Projection::equirectangular);
  camera.eye = {1, 2, 3};
  camera.target = {2, 2, 3};
  const Camera around(camera, 64, 32, no_origin);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 64; ++x) {
      const Ray ray = around.ray(x, y, {}, {0.9F, 0.1F}, 0);
      expect_near(ray.origin, {1, 2, 3}, 0);
      const Vec3d d = to_double(ray.direction);
      EXPECT_NEAR(0.5 - std::atan2(-d.z, d.x) / (2 * pi_d), (x + 0.5) / 64, 1e-6);
      EXPECT_NEAR(std::acos(d.y) / pi_d, (y + 0.5) / 32, 1e-6);
      EXPECT_EQ(around.depth(ray.direction, 7), 7);
    }
}

}  // namespace
}  // namespace tessera::render
