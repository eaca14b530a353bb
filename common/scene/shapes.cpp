#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

#include "common/base/names.hpp"
#include "common/scene/parts.hpp"

namespace tessera::scene {

namespace {

using Geometry = decltype(Shape::geometry);

Geometry quad(Fields& in, Reading&) {
  Quad out;
  out.corner = in.required("corner").point();
  out.edge_u = in.required("edge_u").point();
  out.edge_v = in.required("edge_v").point();
  const auto& u = out.edge_u;
  const auto& v = out.edge_v;
  const Vec3 n{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
  const double area2 = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
  const double bound2 =
      (u[0] * u[0] + u[1] * u[1] + u[2] * u[2]) * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  if (!std::isnormal(area2) || !(area2 > 1e-20 * bound2))
    in.self().fail("the quad has no area: its edges are parallel, or one has no length");
  const double longest2 =
      std::max(u[0] * u[0] + u[1] * u[1] + u[2] * u[2], v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  if (!(longest2 >= length_least * length_least))
    in.self().fail(fmt::format("the quad is too small: no edge is as long as {}", length_least));
  return out;
}

Geometry disk(Fields& in, Reading&) {
  Disk out;
  if (const auto center = in.optional("center")) out.center = center->point();
  if (const auto normal = in.optional("normal")) {
    out.normal = normal->point();
    if (!(std::hypot(out.normal[0], out.normal[1], out.normal[2]) >= direction_least))
      normal->fail("a normal needs a length");
  }
  out.radius = in.number_or("radius", length_least, length_most, out.radius);
  return out;
}

Geometry sphere(Fields& in, Reading&) {
  Sphere out;
  if (const auto center = in.optional("center")) out.center = center->point();
  out.radius = in.number_or("radius", length_least, length_most, out.radius);
  return out;
}

Geometry box(Fields& in, Reading&) {
  Box out;
  const Value low = in.required("low"), high = in.required("high");
  out.low = low.point();
  out.high = high.point();
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (!(out.low[axis] < out.high[axis]))
      high.fail(
          fmt::format("{} is not beyond low's {} along axis {}: the box is flat or inside out",
                      out.high[axis], out.low[axis], "xyz"[axis]));
  const double longest =
      std::max({out.high[0] - out.low[0], out.high[1] - out.low[1], out.high[2] - out.low[2]});
  if (!(longest >= length_least))
    high.fail(fmt::format("the box is too small: no side is as long as {}", length_least));
  return out;
}

Geometry mesh(Fields& in, Reading& reading) { return read_mesh(in, reading); }

struct ShapeType {
  std::string_view name;
  Geometry (*read)(Fields&, Reading&);
};
/// Every type of shape that a scene can name.
constexpr std::array<ShapeType, 5> shape_types{
    {{"quad", quad}, {"disk", disk}, {"sphere", sphere}, {"box", box}, {"mesh", mesh}}};

using MaterialIndex = std::unordered_map<std::string_view, std::uint32_t>;

std::uint32_t read_material(Fields& in, const Reading& reading, const MaterialIndex& index) {
  const Value value = in.required("material");
  const auto found = index.find(value.text());
  if (found != index.end()) return found->second;
  if (reading.materials.empty())
    value.fail(fmt::format("unknown material \"{}\": the scene has none", value.text()));
  std::vector<std::string_view> names;
  for (const Material& material : reading.materials) names.push_back(material.name);
  value.fail(unknown_name("material", value.text(), names));
}

}  // namespace

void check_placed(const Shape& shape, const Transform& to_world, const Reading& reading,
                  const Value& place) {
  if (is_singular(to_world))
    place.fail(
        fmt::format("the transforms of the instance and of its \"{}\" together are singular: they "
                    "flatten space, "
                    "and cannot be undone",
                    shape.name));
  if (is_light(reading.materials[shape.material]) &&
      std::holds_alternative<Sphere>(shape.geometry) && !uniform_scale(to_world))
    place.fail(
        fmt::format("the sphere \"{}\" emits and would become an ellipsoid; expected a transform "
                    "that scales all "
                    "directions alike",
                    shape.name));
}

std::vector<Shape> read_shapes(const Value& shapes, Reading& reading) {
  std::vector<std::string_view> types;
  for (const ShapeType& type : shape_types) types.push_back(type.name);
  MaterialIndex index;
  for (std::uint32_t i = 0; i < reading.materials.size(); ++i)
    index.emplace(reading.materials[i].name, i);

  std::vector<Shape> out;
  for (const Value& value : shapes.items("a list of shapes")) {
    Fields in(value);
    Shape shape;
    const std::string type = read_name(in, "type", "shape type", types);
    const auto name = in.optional("name");
    shape.name = name ? plain_name(*name) : fmt::format("{} {}", type, out.size());
    shape.material = read_material(in, reading, index);
    shape.visibility = read_visibility(in, reading);
    const auto transform = in.optional("transform");
    if (transform) shape.to_world = read_transform(*transform);
    for (const ShapeType& known : shape_types)
      if (type == known.name) shape.geometry = known.read(in, reading);
    in.finish();
    if (transform) check_placed(shape, shape.to_world, reading, *transform);
    out.push_back(std::move(shape));
  }
  return out;
}

}  // namespace tessera::scene
