#pragma once
#include "worker/render/integrators/integrator.hpp"

namespace tessera::render {

/// hemisphere() with the report's sampling of area lights: at each hit, `light_samples` = N points
/// uniform over the lights' area (lights/by_area.hpp),
///   Σ_j f·Le·cos θi·cos θl / r² · V / (N·p(xj)),
/// the rendering equation over surfaces (Kajiya 1986; Veach 1997, section 8.2). What a scattered
/// ray runs into is then not counted again, unless the ray is the camera's or left a delta, to
/// which light samples are blind.
///
/// Points are uniform in area, not in solid angle as path() takes them, because the report draws
/// them so: what replaced that stands beside it in path(). Which light a sample goes to is drawn as
/// path() does; the report has a single light, where there is nothing to choose. There is no
/// multiple importance sampling: close to a light its 1/r² is unbounded. No roulette either (see
/// hemisphere()).
void hemisphere_lights(Trace& trace, std::span<CameraSample> samples);

}  // namespace tessera::render
