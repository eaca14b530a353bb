#pragma once
#include <cstddef>
#include <filesystem>

#include "scenes/generate/noise.hpp"

/// Trees, each of which stands at very many places. The same arguments give the same bytes
/// everywhere.
namespace tessera::generate {

constexpr std::size_t forest_kinds = 20;  ///< meshes of trees

/// Height of the ground, metres.
double ground_height(double x, double z);

/// Writes forest.json, forest.gltf and forest.bin to the folder, which is made if it is not there:
/// at least `trees` instances of 20 trees on hills (EXT_mesh_gpu_instancing), with clearings, a sky
/// and a low sun. Throws Error{failed} with the file's name.
void write_forest(const std::filesystem::path& folder, std::size_t trees);

}  // namespace tessera::generate
