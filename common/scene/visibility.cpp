#include <algorithm>

#include "common/scene/parts.hpp"
#include "common/scene/shadow_catchers.hpp"

namespace tessera::scene {

Visibility read_visibility(Fields& in, const Reading& reading) {
  Visibility out;
  const auto visibility = in.optional("visibility");
  if (!visibility) return out;
  Fields of(*visibility);
  out.camera = of.boolean_or("camera", out.camera);
  out.shadow = of.boolean_or("shadow", out.shadow);
  out.indirect = of.boolean_or("indirect", out.indirect);
  out.holdout = of.boolean_or("holdout", out.holdout);
  out.shadow_catcher = of.boolean_or("shadow_catcher", out.shadow_catcher);
  of.finish();
  check_visibility(out, *visibility);
  if (out.shadow_catcher && !reading.film_transparent)
    of.required("shadow_catcher")
        .fail(
            "what is caught stands in the picture's alpha: expected a film of "
            "\"transparent\": true");
  return out;
}

void check_visibility(const Visibility& visibility, const Value& place) {
  if (visibility.holdout && visibility.shadow_catcher)
    place.fail(
        "a holdout catches no shadows: expected \"holdout\" or \"shadow_catcher\", not both");
}

bool has_shadow_catchers(const Scene& scene) {
  const auto catches = [](const auto& one) { return one.visibility.shadow_catcher; };
  const auto catches_or_shows = [&](const Instance& instance) {
    const std::vector<Shape>& shapes = scene.objects[instance.object].shapes;
    return catches(instance) || std::any_of(shapes.begin(), shapes.end(), catches);
  };
  return std::any_of(scene.shapes.begin(), scene.shapes.end(), catches) ||
         std::any_of(scene.instances.begin(), scene.instances.end(), catches_or_shows);
}

}  // namespace tessera::scene
