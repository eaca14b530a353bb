#pragma once
#include <cstddef>

#include "common/base/limits.hpp"

/// Bounds on what a glTF file may say, beside those of every scene.
namespace tessera::limits {

constexpr std::size_t gltf_values = 4U << 20;  ///< keys and values of its JSON
constexpr std::size_t gltf_zeros = 16U << 20;  ///< elements of an accessor that no bytes stand for
constexpr std::size_t gltf_unpacked = GiB;     ///< of one compressed buffer view or mesh
constexpr std::size_t gltf_draco_elements = 16U << 20;  ///< faces, and points, of one buffer
constexpr std::size_t gltf_draco_ratio = 4096;          ///< of them, to a compressed byte
constexpr std::size_t gltf_made = 512 * MiB;            ///< bytes of numbers and places, in all;
constexpr std::size_t gltf_made_ratio = 64;  ///< and so many more for each byte of its buffers
constexpr std::size_t gltf_instances = 16U << 20;
constexpr int gltf_node_depth = 4096;  ///< nodes above a node

}  // namespace tessera::limits
