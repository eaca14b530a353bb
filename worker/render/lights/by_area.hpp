#pragma once
#include "worker/render/lights/light.hpp"

namespace tessera::render {

/// A point uniform over the light's area, as a direction from context.p: density r² / (cos θl·A)
/// per solid angle, on the light's side of emission or both. This is how a light is sampled in the
/// simplest way (Shirley, Wang, Zimmerman, "Monte Carlo Techniques for Direct Lighting
/// Calculations", 1996, uniform in area), and what the report did; sample() knows better ways. From
/// outside, half of a sphere's points are turned away and give nothing. The environment has no
/// area: a picture is drawn in proportion to all of its light, a constant one as by sample().
LightSample sample_by_area(const Light& light, const LightContext& context, Vec2 u);

}  // namespace tessera::render
