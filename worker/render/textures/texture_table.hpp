#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "common/scene/texture.hpp"
#include "worker/render/surface_detail.hpp"
#include "worker/render/textures/pyramid.hpp"

namespace tessera::render {

/// A texture as one input of a material uses it, in the form that is looked up.
struct TextureUse {
  std::uint32_t texture = 0;  ///< of the table
  std::uint8_t uv_set = 0;
  std::array<float, 6> to_uv{1, 0, 0, 0, 1, 0};  ///< row-major 2×3
};
TextureUse compile(const scene::TextureUse& use);

/// A picture and how it is read beyond its edges.
struct Texture {
  std::shared_ptr<const Pyramid> picture;
  scene::Wrap wrap_u = scene::Wrap::repeat, wrap_v = scene::Wrap::repeat;
  bool nearest = false;  ///< where magnified
};

/// All textures of a scene. Nothing in it changes while it renders; all threads share it.
class TextureTable {
 public:
  /// Most trilinear probes of one look-up, along the footprint's long axis.
  static constexpr int probes_most = 16;

  TextureTable() = default;
  explicit TextureTable(std::vector<Texture> textures) : textures_(std::move(textures)) {}

  /// R, G, B, A, linear, filtered over the footprint. Without a detail, as where a geometry has no
  /// coordinates, the texel at (0, 0).
  [[nodiscard]] Texel lookup(const TextureUse& use,
                             const std::optional<SurfaceDetail>& detail) const;
  /// The same at coordinates of its own: `point` is transformed by the use.
  [[nodiscard]] Texel lookup(const TextureUse& use, const TexturePoint& point) const;
  /// Width and height of the picture in texels.
  [[nodiscard]] Vec2 texels(std::uint32_t texture) const {
    const Pyramid::Level& level = textures_[texture].picture->level(0);
    return {static_cast<float>(level.width), static_cast<float>(level.height)};
  }
  [[nodiscard]] std::size_t size() const { return textures_.size(); }
  [[nodiscard]] std::size_t bytes() const;

 private:
  std::vector<Texture> textures_;
};

}  // namespace tessera::render
