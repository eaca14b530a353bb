#pragma once
#include <cstddef>
#include <filesystem>

/// A shelf of pots, each with a mesh and pictures of its own: what a model of an artist's weighs.
/// The same arguments give the same bytes everywhere, but for what zlib makes of the pictures.
namespace tessera::generate {

/// Writes pottery.glb to the folder, which is made if it is not there: 24 pots of at least
/// `triangles` triangles in all, with normals, tangents and coordinates, and of each a base colour,
/// a normal map, and roughness with metalness, of 512² texels; the shelf, two lamps that are
/// panels, and a camera. Throws Error{failed} with the file's name.
void write_pottery(const std::filesystem::path& folder, std::size_t triangles);

}  // namespace tessera::generate
