#include "client/vary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/base/error.hpp"
#include "common/base/names.hpp"

namespace tessera::client {

namespace {

[[noreturn]] void fail(std::string_view parameter, const std::string& message) {
  std::string key = "--vary";
  if (!parameter.empty()) key += " " + excerpt(parameter);
  throw Error(ErrorKind::bad_input, message, {.file = {}, .key = std::move(key)});
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(' ');
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(' ') - first + 1);
}

/// Follows JSON's strings and brackets from character to character.
class Nesting {
 public:
  void take(char c) {
    if (in_text_) {
      in_text_ = escaped_ || c != '"';
      escaped_ = !escaped_ && c == '\\';
    } else if (c == '"') {
      in_text_ = true;
    } else if (c == '[' || c == '{') {
      ++depth_;
    } else if (c == ']' || c == '}') {
      --depth_;
    }
  }
  [[nodiscard]] bool in_text() const { return in_text_; }
  [[nodiscard]] bool outside() const { return !in_text_ && depth_ <= 0; }

 private:
  int depth_ = 0;
  bool in_text_ = false, escaped_ = false;
};

std::vector<std::string_view> pieces_of(std::string_view text) {
  std::vector<std::string_view> out;
  Nesting nesting;
  std::size_t begin = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    nesting.take(text[i]);
    if (text[i] != ',' || !nesting.outside()) continue;
    out.push_back(text.substr(begin, i - begin));
    begin = i + 1;
  }
  out.push_back(text.substr(begin));
  return out;
}

/// ".5" and "-.5" as JSON writes them: people leave the zero out, JSON does not.
std::string with_leading_zeros(std::string_view text) {
  std::string out;
  Nesting nesting;
  for (std::size_t i = 0; i < text.size(); ++i) {
    nesting.take(text[i]);
    const bool starts_number = text[i] == '.' && i + 1 < text.size() && is_digit(text[i + 1]) &&
                               (i == 0 || !is_digit(text[i - 1]));
    if (starts_number && !nesting.in_text()) out += '0';
    out += text[i];
  }
  return out;
}

Json value_from(std::string_view parameter, std::string_view text) {
  const std::string json = with_leading_zeros(text);
  if (std::string_view("[{\"").find(text.front()) != std::string_view::npos) {
    try {
      return parse_json(json, {});
    } catch (const Error& error) {
      fail(parameter,
           fmt::format("expected a JSON value, found {}: {}", excerpt(text), error.message()));
    }
  }
  // A file name or a name such as 50mm.left is a bare word too: only what is JSON as a whole is
  // taken for it.
  Json value = Json::parse(json, nullptr, false);
  return value.is_discarded() ? Json(text) : value;
}

}  // namespace

Vary vary_from(std::string_view text) {
  const std::size_t equals = text.find('=');
  const std::string_view name = trimmed(text.substr(0, std::min(equals, text.size())));
  if (equals == std::string_view::npos || name.empty())
    fail({}, fmt::format("expected NAME=VALUE,VALUE,… such as samples=1,4,16, found \"{}\"",
                         excerpt(text)));
  if (!is_utf8(text)) fail(name, "expected UTF-8");
  Vary out{std::string(name), {}};
  for (const std::string_view piece : pieces_of(text.substr(equals + 1))) {
    const std::string_view value = trimmed(piece);
    if (value.empty()) fail(name, "expected values with one comma between two of them");
    out.values.push_back(value_from(name, value));
    if (std::count(out.values.begin(), out.values.end(), out.values.back()) > 1)
      fail(name, fmt::format("the value {} stands twice", excerpt(value)));
  }
  return out;
}

std::string value_text(const Json& value) {
  return value.is_string() ? value.get<std::string>() : value.dump();
}

}  // namespace tessera::client
