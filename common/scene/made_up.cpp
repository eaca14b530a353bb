#include "common/scene/made_up.hpp"

#include "common/scene/default_view.hpp"
#include "common/scene/studio.hpp"

namespace tessera::scene {

MadeUp make_up(Scene& scene, double aspect, const std::optional<MadeUp>& first) {
  MadeUp out;
  if (first) {
    out = *first;
  } else {
    out.camera = scene.cameras.empty();
    out.light = !has_light(scene);
    if (!out.camera) {
      out.view = scene.cameras.front();
    } else {
      out.view = view_of(scene, aspect);
      out.view.name = "camera";
    }
  }
  // A camera of the scene's own may have been scaled to nothing at this moment.
  if (scene.cameras.empty()) scene.cameras.push_back(out.view);
  if (out.light) add_studio(scene, out.view);
  return out;
}

}  // namespace tessera::scene
