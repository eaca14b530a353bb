#pragma once
#include <tiny_gltf.h>

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.hpp"
#include "common/scene/description.hpp"
#include "common/scene/scene_file.hpp"

/// A glTF file while it is read. Only common/scene/gltf includes TinyGLTF.
namespace tessera::scene::gltf {

/// The bytes of a buffer: a part of a file, or what a data URI held.
using Bytes = decltype(Image::encoded);

/// A checked file: indices name what is there, numbers are in range. What accessors and buffer
/// views say of bytes is checked where they are read.
struct Asset {
  std::string name;       ///< the file, for errors
  tinygltf::Model model;  ///< without buffers and images
  std::vector<Bytes> buffers;
  std::vector<std::uint64_t> buffer_bytes;  ///< of each; what is there, not what the file says
  std::vector<Image> images;
  std::vector<UsedFile> files;  ///< beside the file itself
  std::vector<std::string> warnings;
  std::vector<Error> problems;  ///< files that it names and that are not there

  /// `place` is a JSON pointer.
  [[noreturn]] void fail(std::string place, std::string message) const {
    throw Error(ErrorKind::bad_input, std::move(message), {.file = name, .key = std::move(place)});
  }
  /// Says it once, however often it is met.
  void warn(const std::string& message);
};

/// Reads the file `path` of a scene: all but the bytes of its buffers. Throws Error. If there are
/// problems, lists have not all that the file says.
Asset read_asset(const SceneFiles& files, const std::string& path);

/// The member of an extension's object, or nullptr.
const tinygltf::Value* member(const tinygltf::Value& object, const std::string& key);
const tinygltf::Value* extension(const tinygltf::ExtensionMap& extensions, const std::string& key);
double number_or(const tinygltf::Value& object, const std::string& key, double fallback);
int integer_or(const tinygltf::Value& object, const std::string& key, int fallback);
std::string text_or(const tinygltf::Value& object, const std::string& key,
                    const std::string& fallback);
Color color_or(const tinygltf::Value& object, const std::string& key, const Color& fallback);

}  // namespace tessera::scene::gltf
