#include "tests/render/support.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstdlib>
#include <map>

#include "worker/scene/build.hpp"

namespace tessera::render::proof {
namespace {

scene::Color gray3(double v) { return {v, v, v}; }

std::uint32_t add_material(scene::Scene& scene, scene::Material material) {
  material.name = "m" + std::to_string(scene.materials.size());
  scene.materials.push_back(std::move(material));
  return static_cast<std::uint32_t>(scene.materials.size() - 1);
}

template <class Shape>
void add_shape(scene::Scene& scene, std::uint32_t material, Shape shape,
               const scene::Transform& to_world) {
  scene::Shape out;
  out.geometry = std::move(shape);
  out.material = material;
  out.to_world = to_world;
  scene.shapes.push_back(std::move(out));
}

}  // namespace

std::filesystem::path source_folder() {
  const char* const folder = std::getenv("TESSERA_SOURCE_DIR");
  return folder != nullptr ? std::filesystem::path(folder) : std::filesystem::current_path();
}

SceneMaker::SceneMaker() { look({0, 0, 5}, {0, 0, 0}); }

std::uint32_t SceneMaker::diffuse(double reflectance) {
  return add_material(description, {"", scene::Diffuse{gray3(reflectance)}});
}
std::uint32_t SceneMaker::emitter(double radiance, bool two_sided) {
  return add_material(description, {"", scene::Emitter{gray3(radiance), two_sided}});
}
std::uint32_t SceneMaker::dielectric(double ior) {
  return add_material(description, {"", scene::Dielectric{ior, gray3(1), gray3(1)}});
}
std::uint32_t SceneMaker::mirror(double reflectance) {
  return add_material(description, {"", scene::Mirror{gray3(reflectance)}});
}
SceneMaker& SceneMaker::add(std::uint32_t material, scene::Quad quad, scene::Transform to_world) {
  add_shape(description, material, quad, to_world);
  return *this;
}
SceneMaker& SceneMaker::add(std::uint32_t material, scene::Disk disk, scene::Transform to_world) {
  add_shape(description, material, disk, to_world);
  return *this;
}
SceneMaker& SceneMaker::add(std::uint32_t material, scene::Sphere sphere,
                            scene::Transform to_world) {
  add_shape(description, material, sphere, to_world);
  return *this;
}
SceneMaker& SceneMaker::add(std::uint32_t material, scene::Box box, scene::Transform to_world) {
  add_shape(description, material, box, to_world);
  return *this;
}
SceneMaker& SceneMaker::add(std::uint32_t material, scene::Mesh mesh, scene::Transform to_world) {
  add_shape(description, material, std::move(mesh), to_world);
  return *this;
}
SceneMaker& SceneMaker::environment(double radiance) {
  description.environment = scene::Environment{gray3(radiance)};
  return *this;
}
SceneMaker& SceneMaker::look(scene::Vec3 eye, scene::Vec3 target, double fov_degrees,
                             scene::Vec3 up) {
  scene::Camera camera;
  camera.name = "main";
  camera.eye = eye;
  camera.target = target;
  camera.up = up;
  camera.fov_y_degrees = fov_degrees;
  description.cameras = {camera};
  return *this;
}
SceneMaker& SceneMaker::moved(const scene::Transform& move) {
  const auto turned = [&m = move.m](const scene::Vec3& v) {
    return scene::Vec3{m[0] * v[0] + m[1] * v[1] + m[2] * v[2],
                       m[4] * v[0] + m[5] * v[1] + m[6] * v[2],
                       m[8] * v[0] + m[9] * v[1] + m[10] * v[2]};
  };
  const auto placed = [&](const scene::Vec3& v) {
    const scene::Vec3 t = turned(v);
    return scene::Vec3{t[0] + move.m[3], t[1] + move.m[7], t[2] + move.m[11]};
  };
  const double grown = scene::uniform_scale(move).value_or(1);
  for (scene::Shape& shape : description.shapes) shape.to_world = move * shape.to_world;
  for (scene::Instance& instance : description.instances) {
    instance.to_world = move * instance.to_world;
  }
  for (scene::PunctualLight& light : description.lights) {
    std::visit(
        [&](auto& shape) {
          if constexpr (requires { shape.position; }) {
            shape.position = placed(shape.position);
            for (double& channel : shape.intensity) channel *= grown * grown;
          }
          if constexpr (requires { shape.direction; }) shape.direction = turned(shape.direction);
        },
        light.shape);
  }
  for (scene::Camera& camera : description.cameras) {
    camera.eye = placed(camera.eye);
    camera.target = placed(camera.target);
    camera.up = turned(camera.up);
    camera.lens.radius *= grown;
    camera.lens.focus_distance *= grown;
  }
  return *this;
}
SceneMaker& SceneMaker::scaled(double factor, scene::Vec3 shift) {
  return moved(translate(shift[0], shift[1], shift[2]) * scale(factor, factor, factor));
}

Scene SceneMaker::build(double albedo_of_emitters) const {
  scene::Scene copy = description;
  Scene scene = worker::build_scene(std::move(copy), accel::Device(), {}, {.coordinates = true});
  if (albedo_of_emitters < 0) return scene;
  for (CompiledMaterial& material : scene.materials) {
    if (!material.emits()) continue;
    Instruction scatter;
    scatter.code = Instruction::Code::lobe;
    scatter.lobe.kind = LobeKind::diffuse;
    scatter.lobe.weight = gray(static_cast<float>(albedo_of_emitters));
    material.program[static_cast<std::size_t>(material.count++)] = scatter;
  }
  return scene;
}

SceneMaker floor_scene() {
  SceneMaker maker;
  maker.add(maker.diffuse(floor_albedo), scene::Quad{{-0.5, 0, -0.5}, {0, 0, 1}, {1, 0, 0}});
  maker.look({-2, 0.3, 0.1}, {0, 0, 0});
  return maker;
}

scene::Image picture_of(int width, const std::vector<int>& exponents) {
  const std::string header = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y " +
                             std::to_string(exponents.size() / static_cast<std::size_t>(width)) +
                             " +X " + std::to_string(width) + "\n";
  std::vector<std::byte> file;
  for (const char c : header) file.push_back(static_cast<std::byte>(c));
  for (const int exponent : exponents) {
    for (int c = 0; c < 3; ++c) file.push_back(std::byte{128});
    file.push_back(static_cast<std::byte>(exponent == -128 ? 0 : 129 + exponent));
  }
  return {"picture.hdr", std::make_shared<const std::vector<std::byte>>(std::move(file))};
}

scene::Transform translate(double x, double y, double z) {
  return {{1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z}};
}
scene::Transform scale(double x, double y, double z) {
  return {{x, 0, 0, 0, 0, y, 0, 0, 0, 0, z, 0}};
}
scene::Transform rotate(scene::Vec3 axis, double degrees) {
  const double length = std::sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
  const double x = axis[0] / length, y = axis[1] / length, z = axis[2] / length;
  const double c = std::cos(degrees * pi_d / 180), s = std::sin(degrees * pi_d / 180), k = 1 - c;
  return {{x * x * k + c, x * y * k - z * s, x * z * k + y * s, 0, y * x * k + z * s, y * y * k + c,
           y * z * k - x * s, 0, z * x * k - y * s, z * y * k + x * s, z * z * k + c, 0}};
}

scene::Mesh ball(int levels, bool smooth) {
  scene::Mesh mesh;
  mesh.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                    {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto key = std::minmax(a, b);
      const auto found = middles.find(key);
      if (found != middles.end()) return found->second;
      std::array<float, 3> p;
      float square = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        p[i] = mesh.positions[a][i] + mesh.positions[b][i];
        square += p[i] * p[i];
      }
      for (float& x : p) x /= std::sqrt(square);
      mesh.positions.push_back(p);
      const auto index = static_cast<std::uint32_t>(mesh.positions.size() - 1);
      middles.emplace(key, index);
      return index;
    };
    std::vector<std::array<std::uint32_t, 3>> finer;
    for (const auto& t : mesh.triangles) {
      const std::uint32_t a = middle(t[0], t[1]), b = middle(t[1], t[2]), c = middle(t[2], t[0]);
      finer.insert(finer.end(), {{t[0], a, c}, {t[1], b, a}, {t[2], c, b}, {a, b, c}});
    }
    mesh.triangles = std::move(finer);
  }
  if (smooth) mesh.normals = mesh.positions;
  return mesh;
}

TaskRequest request_of(const Take& take, std::uint64_t seed) {
  TaskRequest request;
  request.settings.width = take.side;
  request.settings.height = take.side;
  request.settings.bounces = take.bounces;
  request.settings.light_samples = take.light_samples;
  request.settings.integrator = take.integrator;
  request.settings.sampler = take.sampler;
  request.settings.filter = "box";
  request.settings.seed = seed;
  request.window = {0, 0, take.side, take.side};
  request.samples = {0, take.samples};
  request.aovs = true;
  return request;
}

RenderedTask render(const Scene& scene, const Take& take, std::uint64_t seed) {
  tbb::task_arena arena(take.threads);
  auto done = render_task(scene, request_of(take, seed), arena);
  EXPECT_TRUE(done.has_value());
  EXPECT_EQ(done->stats.rejected, 0);
  return std::move(*done);
}

Estimate estimate_of(const std::vector<double>& values) {
  Estimate out;
  out.replicates = static_cast<int>(values.size());
  for (const double value : values) out.mean += value;
  out.mean /= out.replicates;
  double squares = 0;
  for (const double value : values) squares += (value - out.mean) * (value - out.mean);
  out.error = std::sqrt(squares / (out.replicates - 1) / out.replicates);
  return out;
}

Estimate measure(const Scene& scene, const Take& take, int replicates) {
  std::vector<double> means;
  for (int k = 0; k < replicates; ++k) {
    const RenderedTask done = render(scene, take, 1000 + static_cast<std::uint64_t>(k));
    double sum = 0;
    for (const float value : done.image.plane(image::R)) sum += value;
    means.push_back(sum / static_cast<double>(done.image.pixels()));
  }
  return estimate_of(means);
}

double student_bound(int degrees_of_freedom) {
  // Quantiles at 1 − 0.5e-4 by the expansion of Cornish and Fisher about the normal's 3.8906
  // (Abramowitz and Stegun, 26.7.5); within 1 % from 15 degrees on.
  const double z = 3.89059, n = degrees_of_freedom;
  const double z3 = z * z * z, z5 = z3 * z * z, z7 = z5 * z * z;
  return z + (z3 + z) / (4 * n) + (5 * z5 + 16 * z3 + 3 * z) / (96 * n * n) +
         (3 * z7 + 19 * z5 + 17 * z3 - 15 * z) / (384 * n * n * n);
}

void expect_mean(const Estimate& estimate, double expected, double precision) {
  EXPECT_GE(estimate.replicates, 16);
  EXPECT_LE(estimate.error, precision * expected) << "not precise enough to say anything";
  const double tolerance =
      student_bound(estimate.replicates - 1) * estimate.error + 2e-6 * expected;
  EXPECT_NEAR(estimate.mean, expected, tolerance)
      << "standard error " << estimate.error << " of " << estimate.replicates << " replicates";
}

}  // namespace tessera::render::proof
