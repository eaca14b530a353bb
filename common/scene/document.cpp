#include "common/scene/document.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/base/limits.hpp"

namespace tessera::scene {

namespace {
constexpr std::size_t nodes_most = std::size_t{1} << 26;  // 1.5 GiB of nodes

/// The part of the parser's sentence that says what is wrong; its own place counts differently from
/// ours.
std::string syntax_message(std::string_view what) {
  const std::size_t at = what.find("syntax error");
  std::string said(at == std::string_view::npos ? what : what.substr(at));
  if (said.size() > 200) said = said.substr(0, 200) + "…";
  return "not valid JSON: " + said;
}
}  // namespace

std::string_view name_of(Kind kind) {
  switch (kind) {
    case Kind::null:
      return "null";
    case Kind::boolean:
      return "true or false";
    case Kind::integer:
    case Kind::number:
      return "a number";
    case Kind::text:
      return "a string";
    case Kind::array:
      return "a list";
    case Kind::object:
      return "an object";
  }
  return "a value";
}

/// Fills a document from the parser's events. The parser does not say where a token began, so a
/// cursor follows it: from the end of the last token to the start of this one there are only white
/// space, commas and colons.
class Builder : public nlohmann::json_sax<nlohmann::json> {
 public:
  explicit Builder(Document& document) : document_(document), text_(document.text_) {
    if (text_.starts_with("\xEF\xBB\xBF")) cursor_ = 3;
  }

  std::string problem;
  std::size_t problem_offset = 0;

  bool null() override {
    return leaf(
        Kind::null, [](Node&) {}, 4);
  }
  bool boolean(bool value) override {
    return leaf(
        Kind::boolean, [&](Node& node) { node.boolean = value; }, value ? 4 : 5);
  }
  bool number_integer(number_integer_t value) override {
    return leaf(
        Kind::integer, [&](Node& node) { node.integer = value; }, 0);
  }
  bool number_unsigned(number_unsigned_t value) override {
    if (value > static_cast<number_unsigned_t>(INT64_MAX))
      return number_float(static_cast<double>(value), {});
    return number_integer(static_cast<number_integer_t>(value));
  }
  bool number_float(number_float_t value, const string_t&) override {
    return leaf(
        Kind::number, [&](Node& node) { node.number = value; }, 0);
  }
  bool string(string_t& value) override { return text(value); }
  bool key(string_t& value) override { return text(value, true); }
  bool binary(binary_t&) override { return false; }  // there is none in JSON
  bool start_object(std::size_t) override { return open(Kind::object); }
  bool start_array(std::size_t) override { return open(Kind::array); }
  bool end_array() override { return close(); }
  bool end_object() override { return no_doubled_key() && close(); }
  bool parse_error(std::size_t position, const std::string&,
                   const nlohmann::detail::exception& error) override {
    if (dynamic_cast<const nlohmann::detail::out_of_range*>(&error) != nullptr) {
      skip_blanks();
      return refuse("a number beyond the range of double precision", cursor_);
    }
    return refuse(syntax_message(error.what()), position == 0 ? 0 : position - 1);
  }

 private:
  bool refuse(std::string what, std::size_t offset) {
    problem = std::move(what);
    problem_offset = offset;
    return false;
  }
  void skip_blanks() {
    cursor_ = std::min(text_.find_first_not_of(" \t\r\n,:", cursor_), text_.size());
  }
  /// A new node at the cursor; false if there is no room for more.
  bool append(Kind kind) {
    skip_blanks();
    if (document_.nodes_.size() >= nodes_most)
      return refuse(
          fmt::format("more than {} values; large meshes belong into OBJ files", nodes_most),
          cursor_);
    Node node;
    node.kind = kind;
    node.offset = static_cast<std::uint32_t>(cursor_);
    node.end = static_cast<std::uint32_t>(document_.nodes_.size() + 1);
    document_.nodes_.push_back(node);
    return true;
  }
  template <class Set>
  bool leaf(Kind kind, Set set, std::size_t length) {
    if (!append(kind)) return false;
    set(document_.nodes_.back());
    if (length != 0)
      cursor_ += length;
    else
      cursor_ = std::min(text_.find_first_not_of("+-.0123456789eE", cursor_), text_.size());
    count();
    return true;
  }
  bool text(string_t& value, bool is_key = false) {
    if (!append(Kind::text)) return false;
    document_.nodes_.back().text = static_cast<std::uint32_t>(document_.strings_.size());
    document_.strings_.push_back(std::move(value));
    ++cursor_;
    while (cursor_ < text_.size() && text_[cursor_] != '"')
      cursor_ += text_[cursor_] == '\\' ? 2 : 1;
    ++cursor_;
    if (!is_key) count();
    return true;
  }
  bool open(Kind kind) {
    if (!append(kind)) return false;
    if (open_.size() >= static_cast<std::size_t>(limits::json_depth))
      return refuse(fmt::format("nested deeper than {} levels", limits::json_depth), cursor_);
    document_.nodes_.back().count = 0;
    count();
    open_.push_back(static_cast<std::uint32_t>(document_.nodes_.size() - 1));
    ++cursor_;
    return true;
  }
  bool close() {
    skip_blanks();
    ++cursor_;
    document_.nodes_[open_.back()].end = static_cast<std::uint32_t>(document_.nodes_.size());
    open_.pop_back();
    return true;
  }
  void count() {
    if (!open_.empty()) ++document_.nodes_[open_.back()].count;
  }
  bool no_doubled_key() {
    std::vector<std::uint32_t> keys;
    const auto size = static_cast<std::uint32_t>(document_.nodes_.size());
    for (std::uint32_t at = open_.back() + 1; at < size; at = document_.nodes_[at + 1].end)
      keys.push_back(at);
    const auto name = [&](std::uint32_t at) -> const std::string& {
      return document_.string(document_.nodes_[at]);
    };
    std::stable_sort(keys.begin(), keys.end(), [&](auto a, auto b) { return name(a) < name(b); });
    const auto same = std::adjacent_find(keys.begin(), keys.end(),
                                         [&](auto a, auto b) { return name(a) == name(b); });
    if (same == keys.end()) return true;
    const Place first = document_.place_at(document_.nodes_[same[0]].offset);
    return refuse(
        fmt::format("the key \"{}\" stands twice in one object, first at line {}, column {}",
                    name(same[0]).substr(0, 64), first.line, first.column),
        document_.nodes_[same[1]].offset);
  }

  Document& document_;
  std::string_view text_;
  std::size_t cursor_ = 0;
  std::vector<std::uint32_t> open_;
};

Document::Document(std::string text, std::string name, PathStyle style)
    : text_(std::move(text)), name_(std::move(name)), style_(style) {
  if (text_.size() > limits::scene_json_bytes)
    throw Error(
        ErrorKind::too_large,
        fmt::format("{} bytes; a scene file may have {}", text_.size(), limits::scene_json_bytes),
        {.file = name_, .key = {}});
  Builder builder(*this);
  const char* const first = text_.data();
  if (!nlohmann::json::sax_parse(first, first + text_.size(), &builder))
    throw Error(ErrorKind::bad_input, builder.problem, place_at(builder.problem_offset));
}

Place Document::place_at(std::size_t offset) const {
  const std::string_view before = std::string_view(text_).substr(0, std::min(offset, text_.size()));
  const std::size_t newline = before.rfind('\n');
  const std::size_t start = newline == std::string_view::npos ? 0 : newline + 1;
  return {.file = name_,
          .line = 1 + static_cast<int>(std::count(before.begin(), before.end(), '\n')),
          .column = 1 + static_cast<int>(before.size() - start),
          .key = {}};
}

std::string Document::path(std::uint32_t index) const {
  const bool pointer = style_ == PathStyle::pointer;
  std::string out;
  std::uint32_t at = 0;
  while (at != index) {
    std::uint32_t child = at + 1;
    if (nodes_[at].kind == Kind::array) {
      std::size_t position = 0;
      for (; index >= nodes_[child].end; child = nodes_[child].end) ++position;
      out += pointer ? fmt::format("/{}", position) : fmt::format("[{}]", position);
      at = child;
    } else {
      while (index >= nodes_[child + 1].end) child = nodes_[child + 1].end;
      if (pointer || !out.empty()) out += pointer ? '/' : '.';
      out += string(nodes_[child]).substr(0, 64);
      if (child == index) break;  // the key itself
      at = child + 1;
    }
  }
  return out;
}

Place Document::place(std::uint32_t index) const {
  Place out = place_at(nodes_[index].offset);
  out.key = path(index);
  return out;
}

Place Document::place_of_lacking(std::uint32_t object, std::string_view key) const {
  Place out = place(object);
  if (style_ == PathStyle::pointer)
    out.key += '/';
  else if (!out.key.empty())
    out.key += '.';
  out.key += key;
  return out;
}

}  // namespace tessera::scene
