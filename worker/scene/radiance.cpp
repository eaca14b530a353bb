#include "worker/scene/radiance.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "worker/render/fastmath.hpp"

namespace tessera::worker {
namespace {

using render::Vec2;

/// A face is cut into so many squares in each direction, at most.
constexpr int cuts_most = 8;
/// The greatest length of such a square's edge, in texels, where there are fewer.
constexpr float edge_texels = 4;

/// A sum of a picture's colours, each filtered over a part of a face.
class Mean {
 public:
  Mean(const render::TextureUse& use, const render::TextureTable& textures)
      : use_(use), textures_(textures) {}

  void add(Vec2 uv, Vec2 across, Vec2 along, double weight = 1) {
    const render::Texel texel =
        textures_.lookup(use_, render::TexturePoint{.uv = uv, .across = across, .along = along});
    for (std::size_t c = 0; c < 3; ++c) sum_[c] += weight * static_cast<double>(texel[c]);
    weight_ += weight;
  }
  [[nodiscard]] render::Color value() const {
    return render::to_color({sum_[0] / weight_, sum_[1] / weight_, sum_[2] / weight_});
  }
  /// Into how many parts an edge along `way` of the coordinates is cut.
  [[nodiscard]] int cuts(Vec2 way) const {
    const std::array<float, 6>& m = use_.to_uv;
    const Vec2 size = textures_.texels(use_.texture);
    const float x = (m[0] * way.x + m[1] * way.y) * size.x;
    const float y = (m[3] * way.x + m[4] * way.y) * size.y;
    const float parts = std::ceil(std::sqrt(x * x + y * y) / edge_texels);
    return parts < cuts_most ? std::max(1, static_cast<int>(parts)) : cuts_most;
  }

 private:
  const render::TextureUse& use_;
  const render::TextureTable& textures_;
  std::array<double, 3> sum_{};
  double weight_ = 0;
};

Vec2 between(Vec2 a, Vec2 b) { return {b.x - a.x, b.y - a.y}; }
Vec2 part(Vec2 way, int parts) {
  const auto of = static_cast<float>(parts);
  return {way.x / of, way.y / of};
}

enum class Face { triangle, quad, ellipse };

/// Triangles are cut into `n`² like themselves; of a quad each of `n`² cells has two. Of these an
/// ellipse has those whose middles it holds.
void add_flat(Vec2 a, Vec2 b, Vec2 c, Face face, Mean& mean) {
  const Vec2 ab = between(a, b), ac = between(a, c);
  const int n = std::max({mean.cuts(ab), mean.cuts(ac), mean.cuts(between(b, c))});
  const Vec2 step_b = part(ab, n), step_c = part(ac, n);
  const bool quad = face != Face::triangle;
  const auto add = [&](float i, float j) {
    const float x = 2 * i / static_cast<float>(n) - 1, y = 2 * j / static_cast<float>(n) - 1;
    if (face == Face::ellipse && x * x + y * y > 1) return;
    mean.add({a.x + step_b.x * i + step_c.x * j, a.y + step_b.y * i + step_c.y * j}, step_b,
             step_c);
  };
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n && (quad || i + j < n); ++i) {
      const auto x = static_cast<float>(i), y = static_cast<float>(j);
      add(x + 1.0F / 3, y + 1.0F / 3);
      if (quad || i + j < n - 1) add(x + 2.0F / 3, y + 2.0F / 3);
    }
  }
}

/// All of the picture, each row by how much of the sphere it covers.
void add_sphere(Mean& mean) {
  constexpr int columns = 16, rows = 8;
  for (int j = 0; j < rows; ++j) {
    const float v = (static_cast<float>(j) + 0.5F) / rows;
    const double weight = render::fast::sincos(render::pi_d * static_cast<double>(v)).first;
    for (int i = 0; i < columns; ++i) {
      mean.add({(static_cast<float>(i) + 0.5F) / columns, v}, {1.0F / columns, 0}, {0, 1.0F / rows},
               weight);
    }
  }
}

render::Color mean_of(const render::Geometry& geometry, std::uint32_t face,
                      const render::TextureUse& use, const render::TextureTable& textures) {
  Mean mean(use, textures);
  if (geometry.kind == render::GeometryKind::spheres) {
    add_sphere(mean);
    return mean.value();
  }
  const auto& own = geometry.uvs[use.uv_set];
  const auto& uvs = own.empty() ? geometry.uvs[0] : own;
  if (uvs.empty()) {
    mean.add({}, {}, {});
  } else if (geometry.kind == render::GeometryKind::quads) {
    const accel::Quad& quad = geometry.quads[face];
    add_flat(uvs[quad[0]], uvs[quad[1]], uvs[quad[3]], geometry.round ? Face::ellipse : Face::quad,
             mean);
  } else {
    const accel::Triangle& triangle = geometry.triangles[face];
    add_flat(uvs[triangle[0]], uvs[triangle[1]], uvs[triangle[2]], Face::triangle, mean);
  }
  return mean.value();
}

}  // namespace

std::vector<render::Color> mean_radiances(const render::Geometry& geometry,
                                          std::span<const render::CompiledMaterial> materials,
                                          const render::TextureTable& textures) {
  std::vector<render::Color> out(geometry.faces());
  tbb::parallel_for(
      std::uint32_t{0}, static_cast<std::uint32_t>(geometry.faces()), [&](std::uint32_t face) {
        const render::CompiledMaterial& material = materials[geometry.materials[face]];
        out[face] = material.radiance;
        if (material.radiance_texture)
          out[face] *= mean_of(geometry, face, *material.radiance_texture, textures);
      });
  return out;
}

}  // namespace tessera::worker
