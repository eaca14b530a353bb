#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "worker/render/scene.hpp"
#include "worker/scene/arrange.hpp"

namespace tessera::worker {

/// A face that emits: where it stands in its group.
struct EmittingFace {
  std::uint32_t geometry = 0;
  std::uint32_t primitive = 0;
  render::Color radiance;  ///< mean over the face
  bool with_next = false;  ///< it and the next face are one parallelogram, and one light
};

struct MergedGroup {
  render::Group group;
  std::vector<EmittingFace> emitters;  ///< in the order of Geometry::emitters
  std::array<double, 3> origin{};      ///< what was subtracted from its positions
};

/// Copies the shapes into as few geometries as their kinds and flags allow, in double relative to
/// `origin`, and frees each mesh as soon as its last copy is made. Of faces that emit, those are
/// listed whose picture is not black; two triangles that are a parallelogram of one radiance are
/// one. `all_coordinates`: those of set 0 are kept where no material wants them, too.
MergedGroup merge(std::span<const PlacedShape> shapes,
                  std::span<const render::CompiledMaterial> materials,
                  const render::TextureTable& textures, const std::array<double, 3>& origin,
                  bool all_coordinates);

}  // namespace tessera::worker
