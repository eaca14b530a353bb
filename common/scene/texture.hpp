#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

/// Pictures that materials look values up in, as a scene's files describe them. Nothing is decoded
/// here.
namespace tessera::scene {

using Color = std::array<double, 3>;

/// A part of a file: an image that lies within a .glb, or a whole file.
struct FileRange {
  std::filesystem::path file;  ///< on this machine
  std::uint64_t offset = 0;    ///< bytes
  std::uint64_t size = 0;      ///< bytes; 0: up to the file's end
};

/// A picture as its decoder will read it; its format is told from its first bytes.
struct Image {
  std::string name;  ///< for errors: the file as a person finds it, or where in a file it stands
  std::variant<FileRange, std::shared_ptr<const std::vector<std::byte>>> encoded;
};

enum class Wrap : std::uint8_t { repeat, mirrored_repeat, clamp_to_edge };
enum class ColorSpace : std::uint8_t {
  srgb,   ///< integer texels are decoded by the sRGB curve; float texels are linear anyhow
  linear  ///< numbers are taken as they stand
};

/// An image and how it is read between and beyond its texels.
struct Texture {
  std::uint32_t image = 0;  ///< index into Scene::images
  ColorSpace color_space = ColorSpace::srgb;
  Wrap wrap_u = Wrap::repeat, wrap_v = Wrap::repeat;
  bool nearest = false;  ///< magnified texels stay squares
  bool operator==(const Texture&) const = default;
};

/// A texture as one input of a material uses it.
struct TextureUse {
  std::uint32_t texture = 0;  ///< index into Scene::textures
  std::uint8_t uv_set = 0;    ///< 0 or 1
  /// Row-major 2×3: (u', v') = M·(u, v, 1). (0, 0) is the outer corner of the picture's upper left
  /// texel and v runs down, as in glTF.
  std::array<double, 6> to_uv{1, 0, 0, 0, 1, 0};
};

/// A colour: the factor, times the texture's R, G, B where there is one.
struct ColorInput {
  Color factor{1, 1, 1};
  std::optional<TextureUse> texture;
};
/// A number: the factor, times one channel of the texture where there is one.
struct ScalarInput {
  double factor = 1;
  std::optional<TextureUse> texture;
  std::uint8_t channel = 0;  ///< 0…3: R, G, B, A
};
/// Bends the shading normal by a tangent-space map: texel·2 − 1, x and y times `scale`.
struct NormalMap {
  TextureUse texture;
  double scale = 1;
};
/// Bends the shading normal by a height field: the texture's R times `height`, in the scene's
/// lengths, along the normal.
struct BumpMap {
  TextureUse texture;
  double height = 1;
};

}  // namespace tessera::scene
