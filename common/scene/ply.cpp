#include "common/scene/ply.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <set>
#include <type_traits>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "common/scene/fields.hpp"
#include "common/scene/ply_header.hpp"
#include "common/scene/read_file.hpp"

namespace tessera::scene {

namespace {

using ply::Element;
using ply::Format;
using ply::Property;
using ply::Type;

/// One number after the other, as the file's format has them.
template <Format format>
class Cursor {
 public:
  explicit Cursor(std::string_view bytes) : at_(bytes.data()), end_(at_ + bytes.size()) {}

  [[nodiscard]] std::size_t left() const { return static_cast<std::size_t>(end_ - at_); }
  /// False if there is none.
  template <class To>
  bool read(Type type, To& out) {
    if constexpr (format == Format::ascii) return read_text(out);
    switch (type) {
      case Type::int8:
        return read_as<std::int8_t>(out);
      case Type::uint8:
        return read_as<std::uint8_t>(out);
      case Type::int16:
        return read_as<std::int16_t>(out);
      case Type::uint16:
        return read_as<std::uint16_t>(out);
      case Type::int32:
        return read_as<std::int32_t>(out);
      case Type::uint32:
        return read_as<std::uint32_t>(out);
      case Type::float32:
        return read_as<float>(out);
      case Type::float64:
        return read_as<double>(out);
    }
    return false;
  }

 private:
  template <class From, class To>
  bool read_as(To& out) {
    if (left() < sizeof(From)) return false;
    std::array<char, sizeof(From)> bytes;
    std::memcpy(bytes.data(), at_, sizeof(From));
    at_ += sizeof(From);
    if constexpr (format == Format::big_endian) std::reverse(bytes.begin(), bytes.end());
    From value;
    std::memcpy(&value, bytes.data(), sizeof(From));
    return convert(value, out);
  }
  /// False for a value that no index can have.
  template <class From, class To>
  static bool convert(From value, To& out) {
    if constexpr (std::is_integral_v<To> && std::is_floating_point_v<From>) {
      if (!(value >= 0 && value <= static_cast<From>(4294967040.0))) return false;
      out = static_cast<To>(value);
    } else if constexpr (std::is_integral_v<To> && std::is_signed_v<From>) {
      if (value < 0) return false;
      out = static_cast<To>(static_cast<std::make_unsigned_t<From>>(value));
    } else {
      out = static_cast<To>(value);
    }
    return true;
  }
  template <class To>
  bool read_text(To& out) {
    while (at_ != end_ && (*at_ == ' ' || *at_ == '\n' || *at_ == '\r' || *at_ == '\t')) ++at_;
    double value = 0;
    const auto [end, problem] = std::from_chars(at_, end_, value);
    if (problem != std::errc() || !std::isfinite(value)) return false;
    at_ = end;
    return convert(value, out);
  }

  const char* at_;
  const char* end_;
};

/// What a property of a vertex fills.
struct Target {
  enum class What : std::uint8_t { nothing, position, normal, uv, color } what = What::nothing;
  std::size_t index = 0;
};

Target target_of(std::string_view name) {
  struct Known {
    std::string_view name;
    Target target;
  };
  using What = Target::What;
  constexpr std::array<Known, 18> known{{{"x", {What::position, 0}},
                                         {"y", {What::position, 1}},
                                         {"z", {What::position, 2}},
                                         {"nx", {What::normal, 0}},
                                         {"ny", {What::normal, 1}},
                                         {"nz", {What::normal, 2}},
                                         {"u", {What::uv, 0}},
                                         {"v", {What::uv, 1}},
                                         {"s", {What::uv, 0}},
                                         {"t", {What::uv, 1}},
                                         {"texture_u", {What::uv, 0}},
                                         {"texture_v", {What::uv, 1}},
                                         {"red", {What::color, 0}},
                                         {"green", {What::color, 1}},
                                         {"blue", {What::color, 2}},
                                         {"alpha", {What::color, 3}},
                                         {"texcoord_u", {What::uv, 0}},
                                         {"texcoord_v", {What::uv, 1}}}};
  for (const Known& one : known)
    if (one.name == name) return one.target;
  return {};
}

float linear_from_srgb(float value) {
  return value <= 0.04045F ? value / 12.92F : std::pow((value + 0.055F) / 1.055F, 2.4F);
}

template <Format format>
class Reader {
 public:
  Reader(const ply::Header& header, std::string_view data, const std::string& name)
      : header_(header), cursor_(data), name_(name) {}

  Mesh read() {
    for (const Element& element : header_.elements) {
      check_count(element);
      if (element.name == "vertex")
        read_vertices(element);
      else if (element.name == "face")
        read_faces(element);
      else
        skip(element);
    }
    if (mesh_.triangles.empty()) refuse("has no face with an area");
    check_indices();
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void refuse(const std::string& message) const {
    throw Error(ErrorKind::bad_input, message, {.file = name_, .key = {}});
  }
  [[noreturn]] void cut_off(const Element& element, std::uint64_t number) const {
    refuse(fmt::format("{} {} of {} is cut off, or holds no number", element.name, number,
                       element.count));
  }

  void check_count(const Element& element) const {
    const std::size_t least =
        format == Format::ascii ? 2 * element.properties.size() : element.least_bytes();
    if (element.properties.empty() ? element.count > 0
                                   : element.count > (cursor_.left() + 1) / least)
      refuse(fmt::format("says {} of {}, and has not the bytes for them: it is cut off",
                         element.count, element.name));
    if (element.count > limits::mesh_vertices)
      throw Error(ErrorKind::too_large,
                  fmt::format("{} of {}; {} is the most", element.count, element.name,
                              limits::mesh_vertices),
                  {.file = name_, .key = {}});
  }

  void read_vertices(const Element& element) {
    if (element.has_list()) refuse("a vertex with a list");
    std::vector<Target> targets;
    std::array<std::size_t, 5> there{};
    std::set<std::pair<Target::What, std::size_t>> seen;
    float one = 1;  // what full colour is
    for (const Property& property : element.properties) {
      targets.push_back(target_of(property.name));
      ++there[static_cast<std::size_t>(targets.back().what)];
      const Target& target = targets.back();
      if (target.what == Target::What::nothing) continue;
      if (!seen.insert({target.what, target.index}).second)
        refuse(fmt::format("vertices have \"{}\" twice, or a second name for it", property.name));
      if (target.what == Target::What::color) one = std::max(one, full(property.type));
    }
    if (there[1] != 3) refuse("expected vertices with x, y and z");
    const bool normals = there[2] == 3, uvs = there[3] == 2, colors = there[4] >= 3;
    mesh_.positions.resize(element.count);
    if (normals) mesh_.normals.resize(element.count);
    if (uvs) mesh_.uvs.resize(element.count);
    if (colors) mesh_.colors.resize(element.count);
    std::array<std::array<float, 4>, 5> values{};
    values[4][3] = one;
    for (std::size_t i = 0; i < element.count; ++i) {
      for (std::size_t k = 0; k < targets.size(); ++k)
        if (!cursor_.read(element.properties[k].type,
                          values[static_cast<std::size_t>(targets[k].what)][targets[k].index]))
          cut_off(element, i);
      mesh_.positions[i] = {values[1][0], values[1][1], values[1][2]};
      for (const float x : mesh_.positions[i])
        if (!(std::abs(static_cast<double>(x)) <= length_most))
          refuse(fmt::format("vertex {} is not within {}", i, length_most));
      if (normals) mesh_.normals[i] = {values[2][0], values[2][1], values[2][2]};
      if (uvs) mesh_.uvs[i] = {values[3][0], 1 - values[3][1]};
      if (colors) mesh_.colors[i] = color_of(values[4], one);
      for (const float x :
           {values[3][0], values[3][1], values[4][0], values[4][1], values[4][2], values[4][3]})
        if (!std::isfinite(x)) refuse(fmt::format("vertex {} has a number that is none", i));
    }
    if (normals) check_normals();
  }

  static float full(Type type) {
    if (type == Type::uint8) return 255;
    return type == Type::uint16 ? 65535 : 1;
  }
  /// Whole numbers are sRGB, others linear.
  static std::array<float, 4> color_of(std::array<float, 4> color, float one) {
    for (std::size_t i = 0; i < 4; ++i) {
      const float value = std::clamp(color[i] / one, 0.0F, 1.0F);
      color[i] = one > 1 && i < 3 ? linear_from_srgb(value) : value;
    }
    return color;
  }

  /// A normal that points nowhere leaves the mesh flat: which way it should go nobody knows.
  void check_normals() {
    for (const auto& n : mesh_.normals) {
      const double most =
          std::max({std::abs(static_cast<double>(n[0])), std::abs(static_cast<double>(n[1])),
                    std::abs(static_cast<double>(n[2]))});
      if (most >= direction_least && most <= length_most) continue;
      mesh_.normals.clear();
      return;
    }
  }

  void read_faces(const Element& element) {
    mesh_.triangles.reserve(element.count);
    std::array<std::uint32_t, limits::polygon_corners> corners{};
    for (std::size_t i = 0; i < element.count; ++i)
      for (const Property& property : element.properties) {
        const bool indices = property.is_list &&
                             (property.name == "vertex_indices" || property.name == "vertex_index");
        if (!indices) {
          skip(element, property, i);
          continue;
        }
        std::uint32_t count = 0;
        if (!cursor_.read(property.count_type, count)) cut_off(element, i);
        if (count > limits::polygon_corners)
          refuse(fmt::format("face {} has {} corners; {} is the most", i, count,
                             limits::polygon_corners));
        for (std::uint32_t k = 0; k < count; ++k)
          if (!cursor_.read(property.type, corners[k])) cut_off(element, i);
        for (std::uint32_t k = 2; k < count; ++k)
          mesh_.triangles.push_back({corners[0], corners[k - 1], corners[k]});
        if (mesh_.triangles.size() > limits::mesh_triangles) refuse("too many triangles");
      }
  }

  void skip(const Element& element) {
    for (std::size_t i = 0; i < element.count; ++i)
      for (const Property& property : element.properties) skip(element, property, i);
  }
  void skip(const Element& element, const Property& property, std::size_t number) {
    std::uint64_t count = 1;
    if (property.is_list && !cursor_.read(property.count_type, count)) cut_off(element, number);
    double passed = 0;
    for (std::uint64_t k = 0; k < count; ++k)
      if (!cursor_.read(property.type, passed)) cut_off(element, number);
  }

  void check_indices() const {
    const std::size_t count = mesh_.positions.size();
    for (std::size_t i = 0; i < mesh_.triangles.size(); ++i)
      for (const std::uint32_t corner : mesh_.triangles[i])
        if (corner >= count)
          refuse(fmt::format("triangle {} names vertex {}, and there are {}", i, corner, count));
  }

  const ply::Header& header_;
  Cursor<format> cursor_;
  const std::string& name_;
  Mesh mesh_;
};

}  // namespace

Mesh parse_ply(std::string_view bytes, const std::string& name) {
  const ply::Header header = ply::parse_header(bytes, name);
  const std::string_view data = bytes.substr(header.bytes);
  switch (header.format) {
    case Format::ascii:
      return Reader<Format::ascii>(header, data, name).read();
    case Format::little_endian:
      return Reader<Format::little_endian>(header, data, name).read();
    case Format::big_endian:
      break;
  }
  return Reader<Format::big_endian>(header, data, name).read();
}

Mesh read_ply(const std::filesystem::path& file, const std::string& name) {
  return parse_ply(read_file(file, name, limits::mesh_file_bytes), name);
}

}  // namespace tessera::scene
