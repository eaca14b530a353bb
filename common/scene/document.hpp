#pragma once
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.hpp"

namespace tessera::scene {

enum class Kind : std::uint8_t { null, boolean, integer, number, text, array, object };

/// "an object", "a number", …: for errors.
std::string_view name_of(Kind kind);

/// A value of a JSON text. All values of a document stand in one array, each before what it holds:
/// 24 bytes a value.
struct Node {
  Kind kind = Kind::null;
  std::uint32_t offset = 0;  ///< of the value's first byte in the text
  std::uint32_t end = 0;     ///< index of the first node behind this value and all that it holds
  union {
    double number = 0;
    std::int64_t integer;
    bool boolean;
    std::uint32_t text;   ///< index into the document's strings
    std::uint32_t count;  ///< items of an array, members of an object
  };
};

/// How errors name a value: "shapes[3].material", or as a JSON pointer, "/shapes/3/material".
enum class PathStyle : std::uint8_t { keys, pointer };

/// A JSON text that a person wrote, and where in it every key and every value stands. In an object
/// each key is a node of text, and its value follows it.
class Document {
 public:
  /// Refuses what is no JSON, doubled keys, nesting deeper than limits::json_depth, numbers beyond
  /// double's range, texts longer than limits::scene_json_bytes. Throws Error{bad_input} with
  /// `name`, line and column.
  Document(std::string text, std::string name, PathStyle style = PathStyle::keys);

  [[nodiscard]] const Node& node(std::uint32_t index) const { return nodes_[index]; }
  [[nodiscard]] const std::string& string(const Node& node) const { return strings_[node.text]; }
  /// The file, line, column and path of keys of a node.
  [[nodiscard]] Place place(std::uint32_t index) const;
  /// The same for the member `key` of an object that has none.
  [[nodiscard]] Place place_of_lacking(std::uint32_t object, std::string_view key) const;
  [[nodiscard]] std::string_view text() const { return text_; }
  /// All values and keys.
  [[nodiscard]] std::size_t size() const { return nodes_.size(); }

 private:
  friend class Builder;
  [[nodiscard]] Place place_at(std::size_t offset) const;
  [[nodiscard]] std::string path(std::uint32_t index) const;

  std::string text_, name_;
  PathStyle style_;
  std::vector<Node> nodes_;
  std::deque<std::string> strings_;
};

}  // namespace tessera::scene
