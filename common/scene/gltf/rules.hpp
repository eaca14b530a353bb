#pragma once
#include <cstdint>
#include <span>
#include <string_view>

namespace tessera::scene::gltf {

/// What the member of an object must be.
enum class Is : std::uint8_t {
  index,    ///< of an item of the list `of`
  indices,  ///< a list of them
  whole,    ///< a whole number, low … high
  number,   ///< low … high
  numbers,  ///< a list of `count` of them; any number of them where count is 0
  text,
  word,  ///< one of the words in `of`, with a comma behind each
  flag,
  list,  ///< of anything
  object
};

struct Field {
  std::string_view key;
  Is is = Is::object;
  bool required = false;
  std::string_view of;
  double low = 0, high = 0;
  std::uint32_t count = 0;
};

/// The members of the objects that stand at `path`: keys with a slash between them, * for every
/// item of a list or member of an object.
struct Rule {
  std::string_view path;
  std::span<const Field> fields;
};

std::span<const Rule> rules();
/// Where an object that names a texture may stand; all have the same members.
std::span<const std::string_view> texture_paths();
std::span<const Field> texture_fields();
std::span<const Field> texture_transform_fields();

}  // namespace tessera::scene::gltf
