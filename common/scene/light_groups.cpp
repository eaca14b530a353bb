#include "common/scene/light_groups.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "common/job/aovs.hpp"
#include "common/scene/parts.hpp"

namespace tessera::scene {

namespace {

std::string group_at(const Value& name) {
  if (!is_light_group(name.text()))
    name.fail_expected("a light group's name, of 1 to 64 letters, digits, _ and -");
  return name.text() == default_light_group ? std::string() : name.text();
}

/// Puts the lights, emitting materials or environment of this name into the group.
void put(const Value& name, const std::string& group, Scene& scene) {
  std::vector<std::string_view> known;
  bool found = false;
  const auto take = [&](std::string_view named, std::string& group_of) {
    known.push_back(named);
    if (named != name.text()) return;
    group_of = group;
    found = true;
  };
  for (PunctualLight& light : scene.lights) take(light.name, light.light_group);
  for (Material& material : scene.materials)
    if (is_light(material)) take(material.name, material.light_group);
  if (scene.environment) take("environment", scene.environment->light_group);
  if (!found) name.fail(unknown_name("light or emitting material", name.text(), known));
}

}  // namespace

std::string read_light_group(Fields& in) {
  const auto group = in.optional("group");
  return group ? group_at(*group) : std::string();
}

void read_light_groups(Fields& root, Scene& out) {
  const auto groups = root.optional("light_groups");
  if (!groups) return;
  for (const Value::Member& member : groups->members()) {
    const std::string group = group_at(member.key);
    for (const Value& name : member.value.items("a list of names")) put(name, group, out);
  }
}

std::vector<std::string> light_groups(const Scene& scene) {
  std::set<std::string> named;
  for (const PunctualLight& light : scene.lights) named.insert(light.light_group);
  for (const Material& material : scene.materials) named.insert(material.light_group);
  if (scene.environment) named.insert(scene.environment->light_group);
  named.erase("");
  std::vector<std::string> out{std::string(default_light_group)};
  out.insert(out.end(), named.begin(), named.end());
  constexpr std::size_t most = 4096;
  if (out.size() > most)
    throw Error(ErrorKind::too_large,
                fmt::format("the scene has {} light groups; {} is the most", out.size(), most));
  return out;
}

void check_light_groups(const std::vector<std::string>& aovs,
                        const std::vector<std::string>& groups) {
  std::vector<std::string> names;
  for (const std::string& group : groups) names.push_back(std::string(light_prefix) + group);
  for (const AovUse& use : aov_uses(aovs))
    if (use.aov == Aov::light && std::find(names.begin(), names.end(), use.name) == names.end())
      throw Error(ErrorKind::bad_input,
                  unknown_name("AOV of a light group", use.name, {names.begin(), names.end()}),
                  {.key = "render.aovs"});
}

}  // namespace tessera::scene
