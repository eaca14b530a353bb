#include "worker/render/scene.hpp"

#include <algorithm>
#include <iterator>

namespace tessera::render {

std::size_t Geometry::bytes() const {
  return positions.bytes() + triangles.bytes() + quads.bytes() + spheres.bytes() +
         normals.size() * sizeof(normals[0]) + materials.size() * sizeof(materials[0]) +
         emitters.size() * sizeof(emitters[0]) +
         (uvs[0].size() + uvs[1].size() + spare_uvs.size()) * sizeof(Vec2) +
         tangents.size() * sizeof(tangents[0]) + colors.size() * sizeof(colors[0]) +
         objects.size() * sizeof(objects[0]);
}

Identity Scene::object_of(const accel::Hit& hit) const {
  const std::uint32_t whole = placements[placement_of(hit)].object;
  if (whole != no_id) return object_identities[whole];
  const std::vector<ObjectFaces>& objects = geometry_of(hit).objects;
  const auto behind = std::upper_bound(
      objects.begin(), objects.end(), hit.primitive,
      [](std::uint32_t face, const ObjectFaces& faces) { return face < faces.first; });
  return object_identities[std::prev(behind)->object];
}

}  // namespace tessera::render
