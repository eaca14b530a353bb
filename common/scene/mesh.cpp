#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/base/limits.hpp"
#include "common/scene/obj.hpp"
#include "common/scene/outline.hpp"
#include "common/scene/parts.hpp"
#include "common/scene/ply.hpp"

namespace tessera::scene {

namespace {

template <std::size_t Size>
std::vector<std::array<float, Size>> read_rows(const Value& value) {
  std::vector<std::array<float, Size>> out;
  const auto rows = value.items(fmt::format("a list of lists of {} numbers", Size));
  out.reserve(rows.size());
  for (const Value& row : rows) {
    std::array<double, Size> numbers{};
    row.numbers(numbers.data(), Size, -length_most, length_most);
    std::array<float, Size>& last = out.emplace_back();
    for (std::size_t i = 0; i < Size; ++i) last[i] = static_cast<float>(numbers[i]);
  }
  return out;
}

std::vector<std::array<std::uint32_t, 3>> read_triangles(const Value& value, std::size_t vertices) {
  std::vector<std::array<std::uint32_t, 3>> out;
  const auto rows = value.items("a list of lists of 3 indices");
  out.reserve(rows.size());
  for (const Value& row : rows) {
    const auto indices = row.items("3 indices of positions");
    if (indices.size() != 3) row.fail_expected("3 indices of positions");
    auto& triangle = out.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) {
      // A number that is no index at all is one kind of mistake, one beyond the list another.
      const std::int64_t index =
          indices[i].integer(0, static_cast<std::int64_t>(limits::mesh_vertices) - 1);
      if (index >= static_cast<std::int64_t>(vertices))
        indices[i].fail(
            fmt::format("index {} is out of range: there are {} positions, the last is {}", index,
                        vertices, static_cast<std::int64_t>(vertices) - 1));
      triangle[i] = static_cast<std::uint32_t>(index);
    }
  }
  return out;
}

/// Only its direction is used, so it must have one, in single precision too.
void check_normals(const Value& normals) {
  for (const Value& normal : normals.items()) {
    std::array<double, 3> n{};
    normal.numbers(n.data(), 3, -length_most, length_most);
    const double largest = std::max({std::abs(n[0]), std::abs(n[1]), std::abs(n[2])});
    if (!(largest >= direction_least)) normal.fail("a normal needs a length");
  }
}

Mesh read_inline(Fields& in) {
  Mesh out;
  const Value positions = in.required("positions");
  out.positions = read_rows<3>(positions);
  if (out.positions.size() < 3) positions.fail("expected at least 3 positions");
  const auto normals = in.optional("normals");
  if (normals) {
    out.normals = read_rows<3>(*normals);
    check_normals(*normals);
  }
  const auto uvs = in.optional("uvs");
  if (uvs) out.uvs = read_rows<2>(*uvs);
  const auto same = [&](const Value& value, std::size_t count) {
    if (count != out.positions.size())
      value.fail(
          fmt::format("expected as many as positions, {}, found {}", out.positions.size(), count));
  };
  if (normals) same(*normals, out.normals.size());
  if (uvs) same(*uvs, out.uvs.size());
  const Value triangles = in.required("triangles");
  out.triangles = read_triangles(triangles, out.positions.size());
  if (out.triangles.empty()) triangles.fail("expected at least one triangle");
  return out;
}

}  // namespace

Mesh read_mesh(Fields& in, Reading& reading) {
  const auto file = in.optional("file");
  if (!file) return read_inline(in);
  for (const std::string_view key : {"positions", "normals", "uvs", "triangles"})
    if (const auto value = in.optional(key))
      value->fail(
          fmt::format("{} and file exclude each other: a mesh is inline or in a file", key));
  std::filesystem::path place;
  if (!reading.attempt([&] { place = reading.use_file(*file); })) return {};
  const std::string& name = file->text();
  const bool obj = name.ends_with(".obj") || name.ends_with(".OBJ");
  if (!obj && !name.ends_with(".ply") && !name.ends_with(".PLY"))
    file->fail_expected("the name of a mesh file that ends in .obj or .ply");
  Mesh out;
  reading.attempt([&] {
    out = obj ? read_obj(place, reading.shown(name)) : read_ply(place, reading.shown(name));
    if (reading.keep() == Keep::outlines) keep_outline(out);
  });
  return out;
}

}  // namespace tessera::scene
