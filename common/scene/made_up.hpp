#pragma once
#include <optional>

#include "common/scene/description.hpp"

namespace tessera::scene {

/// What a scene lacks where it begins, and is given.
struct MadeUp {
  bool camera = false, light = false;
  Camera view;  ///< the first camera where the scene begins, made up or its own
};

/// Gives `scene` a camera that shows all of it on a film of this width over height, and a studio's
/// light, if it has none. At another moment than the first, `first` says what was made up there:
/// neither view nor light follows what moves.
MadeUp make_up(Scene& scene, double aspect, const std::optional<MadeUp>& first);

}  // namespace tessera::scene
