#include "common/scene/ply_header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "common/base/names.hpp"

namespace tessera::scene::ply {

namespace {

constexpr std::size_t header_bytes = 64 * limits::KiB;

struct TypeName {
  std::string_view name;
  Type type;
};
constexpr std::array<TypeName, 16> type_names{{{"char", Type::int8},
                                               {"int8", Type::int8},
                                               {"uchar", Type::uint8},
                                               {"uint8", Type::uint8},
                                               {"short", Type::int16},
                                               {"int16", Type::int16},
                                               {"ushort", Type::uint16},
                                               {"uint16", Type::uint16},
                                               {"int", Type::int32},
                                               {"int32", Type::int32},
                                               {"uint", Type::uint32},
                                               {"uint32", Type::uint32},
                                               {"float", Type::float32},
                                               {"float32", Type::float32},
                                               {"double", Type::float64},
                                               {"float64", Type::float64}}};

class Parser {
 public:
  Parser(std::string_view bytes, const std::string& name)
      : text_(bytes.substr(0, header_bytes)), name_(name) {}

  Header parse() {
    if (next_line() != "ply") fail("expected the word ply: this is no PLY file");
    bool formatted = false;
    for (;;) {
      std::string_view rest = next_line();
      const std::string_view word = take(rest);
      if (word == "end_header") break;
      if (word == "format") {
        read_format(rest);
        formatted = true;
      } else if (word == "element") {
        read_element(rest);
      } else if (word == "property") {
        read_property(rest);
      } else if (word != "comment" && word != "obj_info" && !word.empty()) {
        fail(fmt::format("unknown statement \"{}\"", excerpt(word)));
      }
    }
    if (!formatted) fail("the head has no line with the format");
    out_.bytes = at_;
    return std::move(out_);
  }

 private:
  [[noreturn]] void fail(const std::string& message) const {
    throw Error(ErrorKind::bad_input, message, {.file = name_, .line = line_, .key = {}});
  }

  std::string_view next_line() {
    ++line_;
    const std::size_t end = text_.find('\n', at_);
    if (end == std::string_view::npos)
      fail(fmt::format("the head has no end within {} bytes", text_.size()));
    std::string_view line = text_.substr(at_, end - at_);
    at_ = end + 1;
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
  }

  static std::string_view take(std::string_view& rest) {
    rest.remove_prefix(std::min(rest.find_first_not_of(" \t"), rest.size()));
    const std::size_t end = std::min(rest.find_first_of(" \t"), rest.size());
    const std::string_view word = rest.substr(0, end);
    rest.remove_prefix(end);
    return word;
  }

  void read_format(std::string_view rest) {
    const std::string_view format = take(rest);
    if (format == "binary_little_endian")
      out_.format = Format::little_endian;
    else if (format == "binary_big_endian")
      out_.format = Format::big_endian;
    else if (format != "ascii")
      fail(unknown_name("format", format, {"ascii", "binary_little_endian", "binary_big_endian"}));
  }

  void read_element(std::string_view rest) {
    Element element;
    element.name = std::string(take(rest));
    const std::string_view count = take(rest);
    const char* const last = count.data() + count.size();
    const auto [end, problem] = std::from_chars(count.data(), last, element.count);
    if (problem != std::errc() || end != last || element.name.empty())
      fail("expected an element's name and how many there are");
    out_.elements.push_back(std::move(element));
  }

  void read_property(std::string_view rest) {
    if (out_.elements.empty()) fail("a property before the first element");
    Property property;
    std::string_view type = take(rest);
    if (type == "list") {
      property.is_list = true;
      property.count_type = type_of(take(rest));
      if (property.count_type == Type::float32 || property.count_type == Type::float64)
        fail("the length of a list is a whole number");
      type = take(rest);
    }
    property.type = type_of(type);
    property.name = std::string(take(rest));
    if (property.name.empty()) fail("expected a property's name");
    out_.elements.back().properties.push_back(std::move(property));
  }

  [[nodiscard]] Type type_of(std::string_view name) const {
    std::vector<std::string_view> names;
    for (const TypeName& known : type_names) {
      if (known.name == name) return known.type;
      names.push_back(known.name);
    }
    fail(unknown_name("type", name, names));
  }

  std::string_view text_;
  const std::string& name_;
  std::size_t at_ = 0;
  int line_ = 0;
  Header out_;
};

}  // namespace

std::size_t size_of(Type type) {
  constexpr std::array<std::size_t, 8> sizes{1, 1, 2, 2, 4, 4, 4, 8};
  return sizes[static_cast<std::size_t>(type)];
}

std::size_t Element::least_bytes() const {
  std::size_t out = 0;
  for (const Property& property : properties)
    out += size_of(property.is_list ? property.count_type : property.type);
  return out;
}

bool Element::has_list() const {
  return std::any_of(properties.begin(), properties.end(),
                     [](const Property& property) { return property.is_list; });
}

Header parse_header(std::string_view bytes, const std::string& name) {
  return Parser(bytes, name).parse();
}

}  // namespace tessera::scene::ply
