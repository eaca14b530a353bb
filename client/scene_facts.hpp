#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "common/base/json.hpp"
#include "common/scene/scene_file.hpp"

/// What a scene holds, counted. Pure but for the sizes of its files.
namespace tessera::client {

struct SceneFacts {
  std::string name;
  int width = 0, height = 0;  ///< of its film
  bool film_transparent = false;
  bool shadow_catchers = false;        ///< something catches shadows
  std::uint64_t triangles = 0;         ///< kept in memory; a quad is two, a box twelve
  std::uint64_t triangles_placed = 0;  ///< as rays meet them: those of an object once an instance
  std::uint64_t spheres = 0;           ///< kept in memory
  std::size_t shapes = 0, objects = 0, instances = 0;
  std::size_t materials = 0;
  std::size_t emitting_materials = 0;
  std::size_t lights = 0;  ///< without a size
  bool environment = false;
  std::size_t textures = 0, images = 0;
  std::uint64_t image_bytes = 0;     ///< as they are encoded
  std::uint64_t texture_bytes = 0;   ///< in a worker's memory, with their mip levels
  std::uint64_t geometry_bytes = 0;  ///< of vertices and faces, without the hierarchy over them
  std::uint64_t memory_bytes = 0;    ///< that a worker needs for all of it, about, for the AOVs
                                     ///< that the scene asks for
  std::vector<std::string> variants, animations;
  std::vector<std::string> cameras;
  double duration = 0;  ///< of what moves, seconds
  std::size_t files = 0;
  std::uint64_t file_bytes = 0;
  std::vector<std::string> warnings;
};

/// `decoded_bytes`: of its pictures.
SceneFacts facts_of(const scene::LoadedScene& loaded, std::uint64_t decoded_bytes);
Json to_json(const SceneFacts& facts);
/// Lines for a person.
std::string text_of(const SceneFacts& facts);

}  // namespace tessera::client
