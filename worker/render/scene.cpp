#include "worker/render/scene.hpp"

namespace tessera::render {

std::size_t Geometry::bytes() const {
  return positions.bytes() + triangles.bytes() + quads.bytes() + spheres.bytes() +
         normals.size() * sizeof(normals[0]) + materials.size() * sizeof(materials[0]) +
         emitters.size() * sizeof(emitters[0]) + (uvs[0].size() + uvs[1].size()) * sizeof(Vec2) +
         tangents.size() * sizeof(tangents[0]) + colors.size() * sizeof(colors[0]);
}

}  // namespace tessera::render
