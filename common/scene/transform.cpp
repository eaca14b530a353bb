#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/base/names.hpp"
#include "common/scene/parts.hpp"

namespace tessera::scene {

namespace {

double length(const Vec3& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

Transform translate(const Value& value) {
  const Vec3 by = value.point();
  return {{1, 0, 0, by[0], 0, 1, 0, by[1], 0, 0, 1, by[2]}};
}

Transform scale(const Value& value) {
  Vec3 by;
  if (value.kind() == Kind::array)
    by = value.point();
  else if (value.kind() == Kind::integer || value.kind() == Kind::number)
    by.fill(value.number(-length_most, length_most));
  else
    value.fail_expected("a number, or a list of 3");
  return {{by[0], 0, 0, 0, 0, by[1], 0, 0, 0, 0, by[2], 0}};
}

/// Sine and cosine of an angle in degrees; exact for multiples of 90.
std::array<double, 2> sine_cosine(double degrees) {
  const double turn = std::remainder(degrees, 360.0);
  if (turn == 0) return {0, 1};
  if (turn == 90) return {1, 0};
  if (turn == -90) return {-1, 0};
  if (std::abs(turn) == 180) return {0, -1};
  const double radians = turn * (3.14159265358979323846 / 180.0);
  return {std::sin(radians), std::cos(radians)};
}

/// Rodrigues' formula: counter-clockwise as seen with the axis pointing at the viewer.
Transform rotate(const Value& value) {
  Fields fields(value);
  const Value axis_value = fields.required("axis");
  const Vec3 axis = axis_value.point();
  const double degrees = fields.required("degrees").number(-1e6, 1e6);
  fields.finish();
  const double size = length(axis);
  if (!(size >= direction_least)) axis_value.fail("an axis needs a length");
  const auto [s, c] = sine_cosine(degrees);
  const double x = axis[0] / size, y = axis[1] / size, z = axis[2] / size, t = 1 - c;
  return {{t * x * x + c, t * x * y - s * z, t * x * z + s * y, 0,  //
           t * x * y + s * z, t * y * y + c, t * y * z - s * x, 0,  //
           t * x * z - s * y, t * y * z + s * x, t * z * z + c, 0}};
}

Transform matrix(const Value& value) {
  std::array<double, 16> m{};
  if (value.kind() == Kind::array && value.node().count == 12) {
    value.numbers(m.data(), 12, -length_most, length_most);
  } else if (value.kind() == Kind::array && value.node().count == 16) {
    value.numbers(m.data(), 16, -length_most, length_most);
    if (m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1)
      value.fail("the last row of a matrix of 16 must be 0, 0, 0, 1");
  } else {
    value.fail_expected("12 numbers, three rows of four, or 16 with the row 0, 0, 0, 1");
  }
  Transform out;
  std::copy_n(m.begin(), 12, out.m.begin());
  return out;
}

struct Step {
  std::string_view name;
  Transform (*read)(const Value&);
};
constexpr std::array<Step, 4> steps{
    {{"translate", translate}, {"rotate", rotate}, {"scale", scale}, {"matrix", matrix}}};

Transform read_step(const Value& value) {
  const auto members = value.members();
  std::vector<std::string_view> names;
  for (const Step& step : steps) names.push_back(step.name);
  if (members.size() != 1)
    value.fail(fmt::format(
        "expected an object with one key of translate, rotate, scale, matrix; found {} keys",
        members.size()));
  const std::string& key = members[0].key.text();
  for (const Step& step : steps)
    if (key == step.name) return step.read(members[0].value);
  members[0].key.fail(unknown_name("transform", key, names));
}

}  // namespace

Transform read_transform(const Value& list) {
  Transform out;
  for (const Value& step :
       list.items("a list of steps, each {\"translate\": …}, {\"rotate\": …}, …"))
    out = read_step(step) * out;
  if (is_singular(out))
    list.fail("the transform is singular: it flattens space, and cannot be undone");
  if (!std::all_of(out.m.begin(), out.m.end(), [](double x) { return std::abs(x) <= length_most; }))
    list.fail(fmt::format("the transform has entries beyond {}", length_most));
  return out;
}

}  // namespace tessera::scene
