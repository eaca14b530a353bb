#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <unordered_set>
#include <utility>
#include <vector>

#include "common/scene/gltf/asset.hpp"

namespace tessera::scene::gltf {

/// A file's materials and textures, each made when it is first used.
class Materials {
 public:
  explicit Materials(Asset& asset) : asset_(asset) {}

  /// The index in `take()`'s list of a material of the file; −1 is the one that glTF gives to
  /// primitives without.
  std::uint32_t use(int material);
  /// Into the scene: materials, textures, and the images that those need.
  void move_into(Scene& scene);

 private:
  Material read(int index);
  void read_extensions(const tinygltf::Material& from, const std::string& place, Principled& out);
  void read_volume(const tinygltf::ExtensionMap& extensions, Principled& out);
  void read_specular(const tinygltf::Value& from, const std::string& place, Principled& out);
  void read_clearcoat(const tinygltf::Value& from, const std::string& place, Principled& out);
  void read_anisotropy(const tinygltf::Value& from, const std::string& place, Principled& out);

  struct Use {
    int texture = -1, uv_set = 0;
    const tinygltf::ExtensionMap* extensions = nullptr;
    std::string place;
  };
  /// Nothing, and a warning, where the texture has no image that can be read.
  std::optional<TextureUse> use_texture(const Use& use, ColorSpace space);
  std::optional<TextureUse> member_texture(const tinygltf::Value& object, const std::string& key,
                                           ColorSpace space, const std::string& place);
  std::uint32_t texture_index(int texture, ColorSpace space, int image);
  /// One that no other has, so that a scene that includes the file can tell them apart.
  std::string name_for(const tinygltf::Material& material, int index);

  Asset& asset_;
  std::map<int, std::uint32_t> known_;
  std::map<std::pair<int, ColorSpace>, std::uint32_t> known_textures_;
  std::map<int, std::uint32_t> known_images_;
  std::vector<Material> materials_;
  std::unordered_set<std::string> names_;  ///< of them
  std::vector<Texture> textures_;
  std::vector<Image> images_;
};

}  // namespace tessera::scene::gltf
