#include "common/scene/studio.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string_view>

namespace tessera::scene {

namespace {

constexpr int width = 256, height = 128;

/// A lit panel, in degrees: to the camera's right, and up; softness is half of its edges' width.
struct Panel {
  double azimuth, elevation, half_width, half_height, softness;
  Color radiance;
};
constexpr std::array<Panel, 3> panels{{
    {-52, 46, 30, 22, 8, {3.9, 3.75, 3.5}},   // key
    {68, 18, 24, 30, 12, {0.6, 0.65, 0.72}},  // fill
    {162, 48, 36, 14, 8, {2.3, 2.4, 2.5}},    // from behind
}};

/// 0 up to `low`, 1 from `high` on, smooth between.
double smooth_step(double low, double high, double x) {
  const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

/// From −180 to 180.
double around(double degrees) {
  if (degrees > 180) return degrees - 360;
  return degrees < -180 ? degrees + 360 : degrees;
}

double backdrop(double elevation) {
  return elevation > 0 ? 0.27 + 0.12 * smooth_step(0, 90, elevation)
                       : 0.27 - 0.15 * smooth_step(0, 75, -elevation);
}

/// Arithmetic alone, without a function of the C library that differs from machine to machine.
Color radiance_at(double azimuth, double elevation) {
  const double grey = backdrop(elevation);
  Color out{grey, grey, grey};
  for (const Panel& panel : panels) {
    const auto share = [&](double distance, double half) {
      return 1 - smooth_step(half - panel.softness, half + panel.softness, std::abs(distance));
    };
    const double part = share(around(azimuth - panel.azimuth), panel.half_width) *
                        share(elevation - panel.elevation, panel.half_height);
    for (std::size_t c = 0; c < 3; ++c) out[c] += part * panel.radiance[c];
  }
  return out;
}

using Code = std::array<std::byte, 4>;

/// Radiance's three mantissas and their exponent.
Code code_of(const Color& color) {
  int exponent = 0;
  (void)std::frexp(*std::max_element(color.begin(), color.end()), &exponent);
  Code out{};
  for (std::size_t c = 0; c < 3; ++c)
    out[c] =
        static_cast<std::byte>(std::min(std::lround(std::ldexp(color[c], 8 - exponent)), 255L));
  out[3] = static_cast<std::byte>(exponent + 128);
  return out;
}

/// An HDR file: as a picture's u says, −z, +x and +z lie at a quarter, half and three quarters.
std::vector<std::byte> studio_picture() {
  constexpr std::string_view header = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 128 +X 256\n";
  std::vector<std::byte> out;
  const auto put = [&](int value) { out.push_back(static_cast<std::byte>(value)); };
  for (const char c : header) put(c);
  for (int y = 0; y < height; ++y) {
    std::array<Code, width> row{};
    for (int x = 0; x < width; ++x)
      row[static_cast<std::size_t>(x)] = code_of(
          radiance_at(around(270 - 360 * (x + 0.5) / width), 90 - 180 * (y + 0.5) / height));
    for (const int start : {2, 2, width / 256, width % 256}) put(start);
    for (std::size_t c = 0; c < 4; ++c)
      for (std::size_t x = 0; x < row.size(); ++x) {
        if (x % 128 == 0) put(128);  // as many bytes as they stand
        out.push_back(row[x][c]);
      }
  }
  return out;
}

}  // namespace

void add_studio(Scene& scene, const Camera& camera) {
  const double x = camera.eye[0] - camera.target[0], z = camera.eye[2] - camera.target[2];
  if (!scene.environment) scene.environment = Environment{};
  scene.environment->radiance = {1, 1, 1};
  scene.environment->image = static_cast<std::uint32_t>(scene.images.size());
  scene.environment->rotation_degrees += std::atan2(x, z) * 180 / std::numbers::pi;
  scene.images.push_back(
      {.name = "studio light",
       .encoded = std::make_shared<const std::vector<std::byte>>(studio_picture())});
}

}  // namespace tessera::scene
