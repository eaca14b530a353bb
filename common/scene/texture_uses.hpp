#pragma once
#include <array>
#include <span>
#include <vector>

#include "common/scene/material.hpp"

/// Which textures a material looks up, and by which coordinates.
namespace tessera::scene {

/// Each of its uses of a texture.
std::vector<TextureUse*> texture_uses(Material& material);

/// Whether it looks at texture coordinates of set 0 and of set 1: for textures, or for the
/// directions that they give. `all` are the scene's materials, of which a mix names two.
std::array<bool, 2> coordinate_sets(const Material& material, std::span<const Material> all);

}  // namespace tessera::scene
