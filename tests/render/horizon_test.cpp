#include <gtest/gtest.h>

#include <cmath>

#include "tests/render/support.hpp"
#include "worker/render/camera.hpp"
#include "worker/render/interaction.hpp"

/// A chequered plane to the horizon: what its texture's levels are worth, seen directly and in a
/// mirror.
namespace tessera::render::proof {
namespace {

constexpr int side = 96;
// The picture is 8×8 checks in 128×128 texels. A check is a quarter of a unit wide: the nearest
// pixels see about one, those at the horizon thousands.
constexpr int checks = 8, check_texels = 16;
constexpr float check_width = 0.25F;

TextureTable chequer() {
  constexpr int size = checks * check_texels;
  image::Texels picture{size, size, 1, image::TexelFormat::u8, {}};
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x)
      picture.bytes.push_back((x / check_texels + y / check_texels) % 2 == 0 ? std::byte{255}
                                                                             : std::byte{0});
  return TextureTable({Texture{
      .picture = std::make_shared<const Pyramid>(std::move(picture), scene::ColorSpace::linear)}});
}

/// The plane y = 0; with a mirror, the camera looks at it from the mirror's
/// other side, at 45° to a wall.
class World {
 public:
  explicit World(bool mirrored) : mirrored_(mirrored), scene_(make(mirrored)), table_(chequer()) {
    for (Geometry& geometry : scene_.groups[0].geometries) {
      if (geometry.kind != GeometryKind::quads) continue;
      geometry.details = detail_flag::uv0;
      for (std::size_t i = 0; i < geometry.positions.size(); ++i)
        geometry.uvs[0].push_back({geometry.positions[i][0] / (checks * check_width),
                                   geometry.positions[i][2] / (checks * check_width)});
    }
  }

  /// What the ray through a pixel sees; −1: not the plane. `filtered`: not level 0 alone.
  [[nodiscard]] double seen(const Camera& camera, int x, int y, Vec2 offset, bool filtered) const {
    Ray ray = camera.ray(x, y, offset, {}, 0);
    accel::Hit hit = scene_.intersect(ray);
    if (!hit.any()) return -1;
    Interaction at = surface_at(scene_, ray, hit);
    if (mirrored_) {
      if (at.shading.normal.y > 0.5F) return -1;  // the plane itself
      const Vec3& n = at.shading.normal;
      const Vec3 d = ray.direction - n * (2 * dot(n, ray.direction));
      ray = at.leave(d, std::numeric_limits<float>::infinity(), ray);
      hit = scene_.intersect(ray);
      if (!hit.any()) return -1;
      at = surface_at(scene_, ray, hit);
    }
    if (at.shading.normal.y < 0.5F) return -1;
    TexturePoint point = at.shading.detail->uv[0];
    if (!filtered) point.across = point.along = {};
    return table_.lookup(TextureUse{}, point)[0];
  }
  [[nodiscard]] Camera camera() const { return {scene_.cameras.at(0), side, side, scene_.origin}; }

 private:
  static Scene make(bool mirrored) {
    SceneMaker maker;
    const std::uint32_t material = maker.diffuse(0.5);
    maker.add(material, scene::Quad{{-600, 0, 600}, {1200, 0, 0}, {0, 0, -1200}});
    if (mirrored) maker.add(material, scene::Quad{{-50, 0, -3}, {100, 0, 0}, {0, 50, 0}});
    maker.look({0.3, 12, 0}, {0.4, 11.2, -3}, 50, {0, 1, 0});
    return maker.build();
  }

  bool mirrored_;
  Scene scene_;
  TextureTable table_;
};

struct Errors {
  double filtered = 0, level0 = 0;
  int pixels = 0;
};

/// Root mean squares of one sample at a random place of each pixel, against its true mean.
Errors errors_of(const World& world) {
  const Camera camera = world.camera();
  constexpr int grid = 20;
  Errors out;
  std::uint32_t state = 99;
  const auto random = [&] {
    state = state * 1664525U + 1013904223U;
    return static_cast<float>(state >> 8) * 0x1p-24F - 0.5F;
  };
  for (int y = 0; y < side; ++y) {
    for (int x = y % 4; x < side; x += 4) {
      double mean = 0;
      bool whole = true;
      for (int i = 0; i < grid * grid && whole; ++i) {
        const Vec2 offset{(static_cast<float>(i % grid) + random() + 0.5F) / grid - 0.5F,
                          (static_cast<float>(i / grid) + random() + 0.5F) / grid - 0.5F};
        const double value = world.seen(camera, x, y, offset, false);
        whole = value >= 0;
        mean += value / (grid * grid);
      }
      const float a = random(), b = random();
      if (!whole) continue;
      const double filtered = world.seen(camera, x, y, {a, b}, true) - mean;
      const double level0 = world.seen(camera, x, y, {a, b}, false) - mean;
      out.filtered += filtered * filtered;
      out.level0 += level0 * level0;
      ++out.pixels;
    }
  }
  out.filtered = std::sqrt(out.filtered / out.pixels);
  out.level0 = std::sqrt(out.level0 / out.pixels);
  return out;
}

TEST(Horizon, one_sample_errs_by_a_quarter_of_what_level_0_errs_by) {
  for (const bool mirrored : {false, true}) {
    const Errors errors = errors_of(World(mirrored));
    EXPECT_GT(errors.pixels, side * side / 20);
    EXPECT_LE(errors.filtered, 0.25 * errors.level0)
        << (mirrored ? "in a mirror: " : "directly: ") << errors.filtered << " against "
        << errors.level0 << " over " << errors.pixels << " pixels";
    RecordProperty(mirrored ? "mirrored_ratio" : "direct_ratio",
                   std::to_string(errors.filtered / errors.level0));
  }
}

TEST(Horizon, what_is_magnified_is_as_sharp_as_level_0) {
  const World world(false);
  scene::Camera near;
  near.eye = {0.5, 0.4, 0.5};
  near.target = {0.5, 0, 0.501};
  near.fov_y_degrees = 10;
  const Camera camera(near, side, side, {});
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x)
      ASSERT_EQ(world.seen(camera, x, y, {}, true), world.seen(camera, x, y, {}, false));
}

}  // namespace
}  // namespace tessera::render::proof
