#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace tessera::scene::gltf {

/// A string that names bytes, and where it stands.
struct Uri {
  std::string text;
  std::string place;  ///< JSON pointer
};
struct BufferEntry {
  std::optional<Uri> uri;  ///< without one it is the binary chunk
  std::uint64_t bytes = 0;
  bool fallback = false;  ///< stands for bytes that EXT_meshopt_compression holds elsewhere
};
struct ImageEntry {
  std::string name;
  std::optional<Uri> uri;  ///< this, or a buffer view
  std::int32_t buffer_view = -1;
};

/// What is left to do with a glTF file's JSON once it has been checked.
struct CheckedJson {
  std::vector<BufferEntry> buffers;
  std::vector<ImageEntry> images;
  std::vector<std::string> extensions_used, extensions_required;
  /// Accessors without a buffer view, by number. As the parser wants one of all indices, the text
  /// gives them the first.
  std::vector<std::size_t> without_view;
  std::string rest;  ///< the text without the two: what the parser reads can name no file
};

/// Looks at every value that is used later, and refuses what TinyGLTF would read as something else
/// without a word: types, ranges, indices that name nothing, what is lacking. Extensions that are
/// not known are passed over. Throws Error{bad_input or too_large} with `name`, line, column and
/// JSON pointer.
CheckedJson check_json(std::string text, const std::string& name);

}  // namespace tessera::scene::gltf
