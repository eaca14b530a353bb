#pragma once
#include "worker/render/ray.hpp"
#include "worker/render/scene.hpp"

namespace tessera::render {

/// The radiance that the sampled point of a light sends back along `ray`, which leads to it and is
/// `sample.distance` long: what a path would find that ran into that very point, with the ray's
/// width. For lights whose radiance varies.
Color radiance_at(const Scene& scene, const LightSample& sample, const Ray& ray);

}  // namespace tessera::render
