#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// KHR_draco_mesh_compression's bytes. Only draco.cpp includes Draco's library.
namespace tessera::scene::gltf {

/// What is wanted of a compressed mesh.
struct DracoAttribute {
  std::uint32_t id = 0;  ///< Draco's unique id, which the extension names
  int component_type = 0;
  std::size_t components = 0;
};

struct DracoMesh {
  std::size_t points = 0;
  std::vector<std::uint32_t> corners;              ///< three a face, each below `points`
  std::vector<std::vector<std::byte>> attributes;  ///< as wanted; an element a point, packed
};

/// Throws Error{bad_input or too_large} without a place: for bytes that are no mesh of Draco's
/// bitstream 2.2, that say more faces, points or attributes than the limits allow (before memory is
/// taken for them), or have no such attribute.
DracoMesh decode_draco(std::span<const std::byte> packed, std::span<const DracoAttribute> wanted);

}  // namespace tessera::scene::gltf
