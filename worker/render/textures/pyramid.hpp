#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/image/texels.hpp"
#include "common/scene/texture.hpp"

namespace tessera::render {

/// R, G, B, A: linear.
using Texel = std::array<float, 4>;

/// A picture and its mip levels, each half as wide and high as the one before, rounded down, to
/// 1×1. All are kept in the picture's own depth, those of sRGB pictures encoded so. Level 0 is the
/// picture itself.
class Pyramid {
 public:
  struct Level {
    int width = 0, height = 0;
    std::vector<std::byte> bytes;
  };

  enum class Levels : std::uint8_t { all, first };

  /// Makes the levels with the calling arena's threads; the bits do not depend on them. `space`
  /// says what integer texels mean.
  Pyramid(image::Texels&& picture, scene::ColorSpace space, Levels levels = Levels::all);

  [[nodiscard]] int levels() const { return static_cast<int>(levels_.size()); }
  [[nodiscard]] const Level& level(int number) const {
    return levels_[static_cast<std::size_t>(number)];
  }
  /// 0 ≤ x < width, 0 ≤ y < height.
  [[nodiscard]] Texel texel(const Level& level, int x, int y) const;
  [[nodiscard]] std::size_t bytes() const;

 private:
  void add_levels(scene::ColorSpace space);
  /// A row of level 0 as floats, width of them.
  void decode_row(int y, Texel* out) const;
  [[nodiscard]] Level encode(int width, int height, const std::vector<Texel>& texels,
                             scene::ColorSpace space) const;

  int channels_;
  image::TexelFormat format_;
  const float* decode_ = nullptr;  ///< of integer formats: what each code is …
  const float* decode_alpha_ = nullptr;
  std::vector<Level> levels_;
};

}  // namespace tessera::render
