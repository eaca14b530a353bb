#include "server/http/query.hpp"

#include <algorithm>

#include "common/base/error.hpp"

namespace tessera::server {

namespace {
int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

std::string decoded(std::string_view text) {
  auto out = percent_decoded(text);
  if (!out) throw Error(ErrorKind::bad_input, "the target has a broken escape", {.key = "target"});
  return std::move(*out);
}

template <class Use>
void split(std::string_view text, char separator, Use use) {
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(separator), text.size());
    use(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
}
}  // namespace

std::optional<std::string> percent_decoded(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    char c = text[i];
    if (c == '%') {
      if (i + 2 >= text.size()) return std::nullopt;
      const int high = hex_digit(text[i + 1]);
      const int low = hex_digit(text[i + 2]);
      if (high < 0 || low < 0) return std::nullopt;
      c = static_cast<char>(high * 16 + low);
      i += 2;
    }
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) return std::nullopt;
    out += c;
  }
  return out;
}

std::optional<std::string_view> Target::parameter(std::string_view name) const {
  for (const auto& [key, value] : query)
    if (key == name) return value;
  return std::nullopt;
}

std::string Target::path() const {
  std::string out;
  for (const std::string& segment : segments) out += "/" + segment;
  return out.empty() ? "/" : out;
}

Target parse_target(std::string_view target) {
  if (target.empty() || target.front() != '/')
    throw Error(ErrorKind::bad_input, "expected a path that begins with /", {.key = "target"});
  const std::size_t mark = std::min(target.find('?'), target.size());
  Target out;
  const std::string_view path = target.substr(1, mark - 1);
  split(path, '/', [&](std::string_view part) { out.segments.push_back(decoded(part)); });
  split(target.substr(std::min(mark + 1, target.size())), '&', [&](std::string_view part) {
    const std::size_t equals = std::min(part.find('='), part.size());
    std::string key = decoded(part.substr(0, equals));
    if (out.parameter(key))
      throw Error(ErrorKind::bad_input, "stands twice in the query", {.key = key});
    out.query.emplace_back(std::move(key), decoded(part.substr(std::min(equals + 1, part.size()))));
  });
  return out;
}

}  // namespace tessera::server
