#include <fmt/format.h>

#include <algorithm>

#include "common/base/names.hpp"
#include "common/scene/parts.hpp"

namespace tessera::scene {

Visibility read_visibility(Fields& in) {
  Visibility out;
  const auto visibility = in.optional("visibility");
  if (!visibility) return out;
  Fields of(*visibility);
  out.camera = of.boolean_or("camera", out.camera);
  out.shadow = of.boolean_or("shadow", out.shadow);
  out.indirect = of.boolean_or("indirect", out.indirect);
  out.holdout = of.boolean_or("holdout", out.holdout);
  of.finish();
  return out;
}

std::vector<Object> read_objects(const Value& objects, Reading& reading) {
  std::vector<Object> out;
  for (const Value::Member& member : objects.members()) {
    if (!is_plain_name(member.key.text()))
      member.key.fail("expected a name of 1 to 128 bytes without control characters");
    Fields in(member.value);
    const Value shapes = in.required("shapes");
    const Visibility visibility = read_visibility(in);
    in.finish();
    out.push_back({member.key.text(), read_shapes(shapes, reading)});
    if (out.back().shapes.empty()) shapes.fail("expected at least one shape");
    for (Shape& shape : out.back().shapes) shape.visibility = shape.visibility & visibility;
  }
  return out;
}

std::vector<Instance> read_instances(const Value& instances, const std::vector<Object>& objects,
                                     std::size_t first, const Reading& reading) {
  std::vector<std::string_view> names;
  for (std::size_t i = first; i < objects.size(); ++i) names.push_back(objects[i].name);
  std::vector<Instance> out;
  for (const Value& value : instances.items("a list of instances")) {
    Fields in(value);
    Instance instance;
    const Value object = in.required("object");
    const auto found = std::find(names.begin(), names.end(), object.text());
    if (names.empty())
      object.fail(fmt::format("unknown object \"{}\": the scene has none", object.text()));
    if (found == names.end()) object.fail(unknown_name("object", object.text(), names));
    instance.object =
        static_cast<std::uint32_t>(first) + static_cast<std::uint32_t>(found - names.begin());
    instance.name = in.text_or("name", "");
    const auto transform = in.optional("transform");
    if (transform) instance.to_world = read_transform(*transform);
    instance.visibility = read_visibility(in);
    in.finish();
    for (const Shape& shape : objects[instance.object].shapes)
      check_placed(shape, instance.to_world * shape.to_world, reading, transform.value_or(value));
    out.push_back(instance);
  }
  return out;
}

}  // namespace tessera::scene
