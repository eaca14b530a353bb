#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <random>

#include "common/scene/scene_file.hpp"
#include "tests/render/support.hpp"
#include "worker/render/camera.hpp"
#include "worker/render/interaction.hpp"
#include "worker/scene/build.hpp"

/// The Cornell box against the plainest estimator there is: follow cosine-distributed directions,
/// add what emits, no light sampling, no roulette, other random numbers. It shares with the
/// renderer what a ray meets, and nothing else.
namespace tessera::render::proof {
namespace {

struct Brute {
  const Scene& scene;
  std::vector<Color> reflectance, radiance;
  std::mt19937_64 bits;

  double number() { return static_cast<double>(bits() >> 11) * 0x1p-53; }

  Vec3 cosine_around(const Vec3& n) {
    const double z = std::sqrt(number()), angle = 2 * pi_d * number();
    const double r = std::sqrt(std::max(0.0, 1 - z * z));
    const Frame frame(n);
    return normalize(
        frame.to_world({static_cast<float>(r * std::cos(angle)),
                        static_cast<float>(r * std::sin(angle)), static_cast<float>(z)}));
  }

  double luminance_along(Ray ray, int bounces) {
    double sum = 0;
    std::array<double, 3> weight{1, 1, 1};
    for (int depth = 0; depth <= bounces + 1; ++depth) {
      const accel::Hit hit = scene.intersect(ray);
      if (!hit.any()) break;
      const Interaction at = surface_at(scene, ray, hit);
      Vec3 n = at.shading.normal;
      const bool front = dot(n, ray.direction) < 0;
      if (!front) n = -n;
      const Color emitted = front ? radiance[at.material] : Color{};
      sum += weight[0] * emitted.r + weight[1] * emitted.g + weight[2] * emitted.b;
      const Color& albedo = reflectance[at.material];
      weight = {weight[0] * albedo.r, weight[1] * albedo.g, weight[2] * albedo.b};
      if (weight[0] + weight[1] + weight[2] == 0) break;
      ray = at.leave(cosine_around(n), std::numeric_limits<float>::infinity(), ray);
    }
    return sum / 3;
  }
};

Estimate brute_force(const Scene& scene, const std::vector<scene::Material>& materials, int side,
                     int samples, int bounces) {
  constexpr int replicates = 32;
  std::vector<double> means(replicates);
  const Camera camera(scene.cameras.front(), side, side, scene.origin);
  tbb::parallel_for(0, replicates, [&](int k) {
    Brute brute{scene, {}, {}, std::mt19937_64(static_cast<std::uint64_t>(k) + 99)};
    for (const scene::Material& material : materials) {
      const auto* diffuse = std::get_if<scene::Diffuse>(&material.surface);
      const auto* emitter = std::get_if<scene::Emitter>(&material.surface);
      brute.reflectance.push_back(diffuse != nullptr ? to_color(diffuse->reflectance) : Color{});
      brute.radiance.push_back(emitter != nullptr ? to_color(emitter->radiance) : Color{});
    }
    double sum = 0;
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        for (int s = 0; s < samples; ++s) {
          const Vec2 offset{static_cast<float>(brute.number() - 0.5),
                            static_cast<float>(brute.number() - 0.5)};
          sum += brute.luminance_along(camera.ray(x, y, offset, {}, 0), bounces);
        }
      }
    }
    means[static_cast<std::size_t>(k)] = sum / (static_cast<double>(side) * side * samples);
  });
  return estimate_of(means);
}

Estimate ours(const Scene& scene, int side, int samples, int bounces) {
  std::vector<double> means;
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    const RenderedTask done = render(scene, {side, samples, bounces}, seed);
    double sum = 0;
    for (const std::size_t c : {image::R, image::G, image::B}) {
      for (const float value : done.image.plane(c)) sum += value;
    }
    means.push_back(sum / 3 / static_cast<double>(done.image.pixels()));
  }
  return estimate_of(means);
}

TEST(BruteForce, AgreesOnTheMeanOfTheCornellBox) {
  scene::Scene description = scene::load_scene(source_folder() / "scenes/cornell.json").scene;
  const std::vector<scene::Material> materials = description.materials;
  const Scene scene = worker::build_scene(std::move(description), accel::Device());
  constexpr int side = 32, bounces = 4;
  const Estimate plain = brute_force(scene, materials, side, 48, bounces);
  const Estimate good = ours(scene, side, 8, bounces);
  EXPECT_LT(plain.error, 0.012 * plain.mean);
  EXPECT_LT(good.error, 0.006 * good.mean);
  EXPECT_NEAR(plain.mean, good.mean,
              student_bound(31) * std::sqrt(plain.error * plain.error + good.error * good.error));
}

}  // namespace
}  // namespace tessera::render::proof
