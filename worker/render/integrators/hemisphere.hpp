#pragma once
#include "worker/render/integrators/integrator.hpp"

namespace tessera::render {

/// The founding report's estimator (2019) as written: the rendering equation (Kajiya 1986),
///   Lo(ωo) = Le(ωo) + ∫ f(ωi, ωo)·Li(ωi)·cos θi dωi  ≈  Le + 2π/N·Σ f·Li·cos θi,
/// with directions ωi uniform over the hemisphere, N the samples of the pixel, and Li by the same
/// estimator. Light is found only by running into it. What scatters as a delta (mirrors, smooth
/// glass) is followed by its own sample, as no uniform direction could meet it.
///
/// The mean is right. Each scattering multiplies the second moment of throughput by 4ρ²/3 (albedo
/// ρ), where cosine-distributed directions have ρ²; so in a closed scene the variance grows without
/// bound with depth from ρ = √3/2 on.
///
/// There is no roulette, as there is none in the report: a path ends after `bounces`, where it
/// leaves the scene, or where nothing is scattered. Roulette on throughput would not change the
/// mean and would save rays; but it only ever ends paths that carry little and makes the rest carry
/// more, so the second moment that grows by itself would grow faster.
void hemisphere(Trace& trace, std::span<CameraSample> samples);

}  // namespace tessera::render
