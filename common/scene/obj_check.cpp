#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "common/base/names.hpp"
#include "common/scene/fields.hpp"
#include "common/scene/obj.hpp"

namespace tessera::scene {

namespace {

/// Statements of the OBJ specification that say nothing about a polygon mesh.
constexpr std::array<std::string_view, 38> passed_over{
    "o",    "g",      "s",      "usemtl", "mtllib",   "l",         "p",     "vp",
    "mg",   "cstype", "deg",    "bmat",   "step",     "curv",      "curv2", "surf",
    "parm", "trim",   "hole",   "scrv",   "sp",       "end",       "con",   "bevel",
    "lod",  "usemap", "maplib", "call",   "c_interp", "d_interp",  "ctech", "stech",
    "csh",  "bsp",    "bzp",    "cdc",    "res",      "shadow_obj"};

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

/// The largest index of one kind that a face names, and the line where it does.
struct Largest {
  std::int64_t index = 0;
  int line = 0;
  void see(std::int64_t value, int at) {
    if (value > index) {
      index = value;
      line = at;
    }
  }
};

class Check {
 public:
  explicit Check(const std::string& name) : name_(name) {}

  void line(std::string_view text) {
    ++line_;
    rest_ = text;
    const std::string_view word = next();
    // tinyobjloader ends a line at each of these, also in a comment.
    const std::size_t odd = text.find_first_of(std::string_view("\0\r", 2));
    if (odd != std::string_view::npos && (text[odd] == '\0' || odd + 1 != text.size()))
      fail("a zero byte, or a carriage return within a line: this is no OBJ text");
    if (word.empty() || word.front() == '#') return;
    if (word == "v")
      numbers(3, 7), ++counts_.positions;
    else if (word == "vn")
      numbers(3, 3), ++counts_.normals;
    else if (word == "vt")
      numbers(1, 3), ++counts_.uvs;
    else if (word == "f")
      face();
    else if (std::find(passed_over.begin(), passed_over.end(), word) == passed_over.end())
      fail(fmt::format(
          "unknown statement \"{}\" (expected v, vn, vt, f, or another of the OBJ format)",
          printable(word)));
  }

  ObjCounts finish() {
    in_range(position_, counts_.positions, "position");
    in_range(normal_, counts_.normals, "normal");
    in_range(uv_, counts_.uvs, "texture coordinate");
    line_ = 0;
    if (counts_.triangles == 0) fail("has no faces");
    if (counts_.positions > limits::mesh_vertices || counts_.corners > limits::mesh_vertices)
      fail(fmt::format("more than {} vertices", limits::mesh_vertices));
    return counts_;
  }

 private:
  [[noreturn]] void fail(const std::string& message) const {
    throw Error(ErrorKind::bad_input, message,
                {.file = name_, .line = line_, .column = 0, .key = {}});
  }
  static std::string printable(std::string_view word) {
    std::string out(word.substr(0, 32));
    std::replace_if(
        out.begin(), out.end(), [](char c) { return c < 0x20 || c > 0x7e; }, '?');
    return out;
  }
  std::string_view next() {
    std::size_t first = 0;
    while (first < rest_.size() && is_blank(rest_[first])) ++first;
    std::size_t last = first;
    while (last < rest_.size() && !is_blank(rest_[last])) ++last;
    const std::string_view word = rest_.substr(first, last - first);
    rest_.remove_prefix(last);
    return word;
  }
  void numbers(int least, int most) {
    int count = 0;
    for (std::string_view word = next(); !word.empty() && word.front() != '#';
         word = next(), ++count) {
      const std::string_view digits = word.substr(word.front() == '+' ? 1 : 0);
      double value = 0;
      const auto [end, error] =
          std::from_chars(digits.data(), digits.data() + digits.size(), value);
      const bool whole = error == std::errc() && end == digits.data() + digits.size();
      if (!whole || !(std::abs(value) <= length_most))
        fail(fmt::format("expected a number from {} to {}, found \"{}\"", -length_most, length_most,
                         printable(word)));
    }
    if (count < least || count > most)
      fail(fmt::format("expected {} to {} numbers, found {}", least, most, count));
  }
  /// One index of a corner. Negative ones count back from the last vertex so far.
  std::int64_t index(std::string_view digits, std::size_t so_far, std::string_view word,
                     std::string_view of) {
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc() || end != digits.data() + digits.size() || value == 0)
      fail(fmt::format("expected a corner as 1, 1/2, 1//3 or 1/2/3, counting from 1, found \"{}\"",
                       printable(word)));
    if (value < 0) value += static_cast<std::int64_t>(so_far) + 1;
    if (value <= 0)
      fail(fmt::format("\"{}\" names a {} before the first: {} stand above", printable(word), of,
                       so_far));
    return value;
  }
  void corner(std::string_view word) {
    const std::size_t first = word.find('/');
    position_.see(index(word.substr(0, first), counts_.positions, word, "position"), line_);
    if (first == std::string_view::npos) return;
    const std::string_view behind = word.substr(first + 1);
    const std::size_t second = behind.find('/');
    const std::string_view uv = behind.substr(0, second);
    if (!uv.empty() || second == std::string_view::npos)
      uv_.see(index(uv, counts_.uvs, word, "texture coordinate"), line_);
    if (second != std::string_view::npos)
      normal_.see(index(behind.substr(second + 1), counts_.normals, word, "normal"), line_);
  }
  void face() {
    std::size_t corners = 0;
    for (std::string_view word = next(); !word.empty(); word = next(), ++corners) corner(word);
    if (corners < 3 || corners > limits::polygon_corners)
      fail(fmt::format("expected a face of 3 to {} corners, found {}", limits::polygon_corners,
                       corners));
    counts_.corners += corners;
    counts_.triangles += corners - 2;
    if (counts_.triangles > limits::mesh_triangles)
      fail(fmt::format("more than {} triangles", limits::mesh_triangles));
  }
  void in_range(const Largest& largest, std::size_t count, std::string_view of) {
    if (largest.index <= static_cast<std::int64_t>(count)) return;
    line_ = largest.line;
    fail(fmt::format("{} {} is out of range: the file has {}", of, largest.index, count));
  }

  const std::string& name_;
  int line_ = 0;
  std::string_view rest_;
  ObjCounts counts_;
  Largest position_, normal_, uv_;
};

}  // namespace

ObjCounts check_obj(std::string_view text, const std::string& name) {
  Check check(name);
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    check.line(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return check.finish();
}

}  // namespace tessera::scene
