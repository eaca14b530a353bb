#pragma once
#include <cstring>

#include "worker/render/bsdf/material.hpp"

/// What the tests of materials share.
namespace tessera::render::test {

/// A table of one texture, of one texel.
inline TextureTable one_texel(const Texel& texel) {
  image::Texels picture{
      .width = 1, .height = 1, .channels = 4, .format = image::TexelFormat::f32, .bytes = {}};
  picture.bytes.resize(sizeof texel);
  std::memcpy(picture.bytes.data(), texel.data(), sizeof texel);
  Texture texture;
  texture.picture = std::make_shared<Pyramid>(std::move(picture), scene::ColorSpace::linear);
  return TextureTable({texture});
}

inline ShadingPoint seen_from(const Vec3& wo) {
  ShadingPoint point;
  point.wo = wo;
  point.detail.emplace().has =
      detail_flag::uv0 | detail_flag::uv1 | detail_flag::tangent | detail_flag::color;
  return point;
}

inline Closure closure_at(const scene::Material& material, const Vec3& wo,
                          const TextureTable& textures = {}) {
  Closure closure;
  evaluate(compile(material), textures, seen_from(wo), closure);
  return closure;
}

inline scene::Material of(decltype(scene::Material::surface) surface) {
  scene::Material material;
  material.surface = std::move(surface);
  return material;
}

}  // namespace tessera::render::test
