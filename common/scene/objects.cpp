#include <fmt/format.h>

#include <algorithm>

#include "common/base/names.hpp"
#include "common/scene/parts.hpp"

namespace tessera::scene {

const std::string& plain_name(const Value& value) {
  if (!is_plain_name(value.text()))
    value.fail("expected a name of 1 to 128 bytes without control characters");
  return value.text();
}

std::vector<Object> read_objects(const Value& objects, Reading& reading) {
  std::vector<Object> out;
  for (const Value::Member& member : objects.members()) {
    (void)plain_name(member.key);
    Fields in(member.value);
    const Value shapes = in.required("shapes");
    const Visibility visibility = read_visibility(in, reading);
    in.finish();
    out.push_back({member.key.text(), read_shapes(shapes, reading)});
    if (out.back().shapes.empty()) shapes.fail("expected at least one shape");
    for (Shape& shape : out.back().shapes) {
      shape.visibility = shape.visibility & visibility;
      check_visibility(shape.visibility, member.value);
    }
  }
  return out;
}

void read_instances(const Value& instances, std::size_t first, const Reading& reading, Scene& out) {
  std::vector<std::string_view> names;
  for (std::size_t i = first; i < out.objects.size(); ++i) names.push_back(out.objects[i].name);
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
    if (const auto name = in.optional("name"))
      instance.name = out.instance_names.add(plain_name(*name));
    const auto transform = in.optional("transform");
    if (transform) instance.to_world = read_transform(*transform);
    instance.visibility = read_visibility(in, reading);
    in.finish();
    for (const Shape& shape : out.objects[instance.object].shapes) {
      check_placed(shape, instance.to_world * shape.to_world, reading, transform.value_or(value));
      check_visibility(instance.visibility & shape.visibility, value);
    }
    out.instances.push_back(instance);
  }
}

}  // namespace tessera::scene
