#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "common/scene/description.hpp"
#include "worker/render/render_task.hpp"
#include "worker/render/scene.hpp"

/// What the proofs share: scenes in a few words, and means with their errors.
namespace tessera::render::proof {

/// The project's: TESSERA_SOURCE_DIR, else where the test runs.
std::filesystem::path source_folder();

/// A scene description that grows by calls.
class SceneMaker {
 public:
  SceneMaker();
  std::uint32_t diffuse(double reflectance);
  std::uint32_t emitter(double radiance, bool two_sided = false);
  std::uint32_t dielectric(double ior);
  std::uint32_t mirror(double reflectance);
  SceneMaker& add(std::uint32_t material, scene::Quad quad, scene::Transform to_world = {});
  SceneMaker& add(std::uint32_t material, scene::Disk disk, scene::Transform to_world = {});
  SceneMaker& add(std::uint32_t material, scene::Sphere sphere, scene::Transform to_world = {});
  SceneMaker& add(std::uint32_t material, scene::Box box, scene::Transform to_world = {});
  SceneMaker& add(std::uint32_t material, scene::Mesh mesh, scene::Transform to_world = {});
  SceneMaker& environment(double radiance);
  SceneMaker& look(scene::Vec3 eye, scene::Vec3 target, double fov_degrees = 0.001,
                   scene::Vec3 up = {0.0123, 1, 0.0345});
  /// Moves everything but the environment: shapes, camera and its lens, lights without a size,
  /// which get as much brighter as their light has further to go.
  SceneMaker& moved(const scene::Transform& move);
  /// … by a uniform scale, then a shift.
  SceneMaker& scaled(double factor, scene::Vec3 shift);

  scene::Scene description;
  /// Builds; then gives every material that emits a diffuse lobe of this albedo too, if it is not
  /// negative.
  [[nodiscard]] Scene build(double albedo_of_emitters = -1) const;
};

inline constexpr double floor_albedo = 0.5;
/// A floor at y = 0 whose element at the origin the camera looks at from low on the −x side …
SceneMaker floor_scene();
/// … and the radiance that leaves it.
constexpr double reflected(double irradiance) { return floor_albedo * irradiance / pi_d; }

/// An HDR file `width` texels wide, row by row from the top: gray values that are powers of two, as
/// exponents; −128 is black.
scene::Image picture_of(int width, const std::vector<int>& exponents);

scene::Transform translate(double x, double y, double z);
scene::Transform scale(double x, double y, double z);
/// About an axis through the origin.
scene::Transform rotate(scene::Vec3 axis, double degrees);
/// A sphere of triangles: an octahedron divided `levels` times; all vertices lie on the unit
/// sphere.
scene::Mesh ball(int levels, bool smooth);

struct Take {
  int side = 4;  ///< film, pixels
  std::int64_t samples = 64;
  int bounces = 0;
  int light_samples = 1;
  int threads = 2;
  std::string integrator = "path";
  std::string sampler = "sobol_owen";
};
TaskRequest request_of(const Take& take, std::uint64_t seed);
RenderedTask render(const Scene& scene, const Take& take, std::uint64_t seed);

/// Mean over independent randomisations, and the standard error of that mean.
struct Estimate {
  double mean = 0;
  double error = 0;
  int replicates = 0;
};
Estimate estimate_of(const std::vector<double>& values);
/// The mean of the red channel over the film, from `replicates` seeds.
Estimate measure(const Scene& scene, const Take& take, int replicates = 24);

/// Fails unless the estimate is precise enough to mean something (its error at most `precision` of
/// the expected value), and within Student's two-sided bound at α = 1e-4 of the expected value.
/// Float sums are allowed 2e-6 of the value on top.
void expect_mean(const Estimate& estimate, double expected, double precision = 0.004);
/// Student's bound at α = 1e-4, two-sided.
double student_bound(int degrees_of_freedom);

}  // namespace tessera::render::proof
