#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// What the head of a PLY file says.
namespace tessera::scene::ply {

enum class Format : std::uint8_t { ascii, little_endian, big_endian };
enum class Type : std::uint8_t { int8, uint8, int16, uint16, int32, uint32, float32, float64 };
std::size_t size_of(Type type);

struct Property {
  std::string name;
  Type type = Type::float32;
  bool is_list = false;
  Type count_type = Type::uint8;  ///< of a list's length, which stands before it
};
struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
  /// Bytes of one in a binary file; of lists, those of their lengths alone.
  [[nodiscard]] std::size_t least_bytes() const;
  [[nodiscard]] bool has_list() const;
};
struct Header {
  Format format = Format::ascii;
  std::vector<Element> elements;
  std::size_t bytes = 0;  ///< the data begins here
};

/// Throws Error{bad_input} with `name` and line.
Header parse_header(std::string_view bytes, const std::string& name);

}  // namespace tessera::scene::ply
