#include "worker/render/textures/texture_table.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "worker/render/textures/wrap.hpp"

namespace tessera::render {
namespace {

/// Two texels beside each other in one direction, and how much the second counts.
struct Pair {
  int first, second;
  float share;
};
Pair pair_at(float coordinate, int size, scene::Wrap wrap) {
  const float at = wrapped(coordinate, wrap) * static_cast<float>(size) - 0.5F;
  const float floor = std::floor(at);
  const int index = static_cast<int>(floor);
  return {wrapped_index(index, size, wrap), wrapped_index(index + 1, size, wrap), at - floor};
}

Texel mixed(const Texel& a, const Texel& b, float share) {
  Texel out;
  for (std::size_t c = 0; c < 4; ++c) out[c] = a[c] + (b[c] - a[c]) * share;
  return out;
}

Texel bilinear(const Texture& texture, const Pyramid::Level& level, Vec2 uv) {
  const Pair x = pair_at(uv.x, level.width, texture.wrap_u);
  const Pair y = pair_at(uv.y, level.height, texture.wrap_v);
  const Pyramid& picture = *texture.picture;
  const auto row = [&](int at) {
    return mixed(picture.texel(level, x.first, at), picture.texel(level, x.second, at), x.share);
  };
  return mixed(row(y.first), row(y.second), y.share);
}

int nearest_index(float coordinate, int size, scene::Wrap wrap) {
  return std::min(static_cast<int>(wrapped(coordinate, wrap) * static_cast<float>(size)), size - 1);
}

Texel magnified(const Texture& texture, Vec2 uv) {
  const Pyramid::Level& level = texture.picture->level(0);
  if (!texture.nearest) return bilinear(texture, level, uv);
  return texture.picture->texel(level, nearest_index(uv.x, level.width, texture.wrap_u),
                                nearest_index(uv.y, level.height, texture.wrap_v));
}

/// `width` ≥ 1: of the filter, in texels of level 0. Between two powers of two the levels are mixed
/// linearly.
Texel trilinear(const Texture& texture, Vec2 uv, float width) {
  const Pyramid& picture = *texture.picture;
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(width);
  const int lower = static_cast<int>(bits >> 23) - 127;
  if (lower >= picture.levels() - 1) {
    return picture.texel(picture.level(picture.levels() - 1), 0, 0);
  }
  const float share = std::bit_cast<float>((bits & 0x7fffffU) | 0x3f800000U) - 1;
  const Texel fine =
      lower == 0 ? magnified(texture, uv) : bilinear(texture, picture.level(lower), uv);
  if (share == 0) return fine;
  return mixed(fine, bilinear(texture, picture.level(lower + 1), uv), share);
}

}  // namespace

TextureUse compile(const scene::TextureUse& use) {
  TextureUse out{.texture = use.texture, .uv_set = use.uv_set, .to_uv = {}};
  for (std::size_t i = 0; i < 6; ++i) out.to_uv[i] = static_cast<float>(use.to_uv[i]);
  return out;
}

Texel TextureTable::lookup(const TextureUse& use,
                           const std::optional<SurfaceDetail>& detail) const {
  return lookup(use, detail ? detail->uv[use.uv_set] : TexturePoint{});
}

Texel TextureTable::lookup(const TextureUse& use, const TexturePoint& point) const {
  const Texture& texture = textures_[use.texture];
  const std::array<float, 6>& m = use.to_uv;
  const Vec2 uv{m[0] * point.uv.x + m[1] * point.uv.y + m[2],
                m[3] * point.uv.x + m[4] * point.uv.y + m[5]};
  const Pyramid::Level& level = texture.picture->level(0);
  const Vec2 size{static_cast<float>(level.width), static_cast<float>(level.height)};
  const auto in_texels = [&](Vec2 d) {
    return Vec2{(m[0] * d.x + m[1] * d.y) * size.x, (m[3] * d.x + m[4] * d.y) * size.y};
  };
  const Vec2 a = in_texels(point.across), b = in_texels(point.along);
  const float a2 = a.x * a.x + a.y * a.y, b2 = b.x * b.x + b.y * b.y;
  const Vec2 axis = a2 > b2 ? a : b;
  const float longer = std::sqrt(std::max(a2, b2));
  if (!(longer > 1)) return magnified(texture, uv);
  // Beyond any picture; what follows stays finite.
  if (!(longer < 0x1p24F)) return trilinear(texture, uv, 0x1p24F);
  // The ellipse's area over its long axis, whatever angle the transform left between the two.
  const float shorter = std::max(std::abs(a.x * b.y - a.y * b.x) / longer, 1.0F);
  const int probes = static_cast<int>(
      std::clamp(std::ceil(longer / shorter), 1.0F, static_cast<float>(probes_most)));
  const auto count = static_cast<float>(probes);
  const float width = std::max(shorter, longer / count);
  if (probes == 1) return trilinear(texture, uv, width);
  const Vec2 way{axis.x / size.x, axis.y / size.y};
  Texel sum{};
  for (int i = 0; i < probes; ++i) {
    const float place = (static_cast<float>(i) + 0.5F) / count - 0.5F;
    const Texel one = trilinear(texture, {uv.x + way.x * place, uv.y + way.y * place}, width);
    for (std::size_t c = 0; c < 4; ++c) sum[c] += one[c];
  }
  for (float& value : sum) value /= count;
  return sum;
}

std::size_t TextureTable::bytes() const {
  std::size_t sum = 0;
  std::vector<const Pyramid*> seen;
  for (const Texture& texture : textures_) {
    const Pyramid* const picture = texture.picture.get();
    if (std::find(seen.begin(), seen.end(), picture) != seen.end()) continue;
    seen.push_back(picture);
    sum += picture->bytes();
  }
  return sum;
}

}  // namespace tessera::render
