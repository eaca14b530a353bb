#pragma once
#include "worker/render/integrators/integrator.hpp"

namespace tessera::render {

/// The rendering equation (Kajiya 1986) with directions drawn from the BSDF (Veach 1997, section
/// 2.5), for a diffuse surface by the cosine:
///   Lo(ωo) = Le(ωo) + 1/N·Σ f·Li·cos θi / p(ωi),
/// whose terms are ρ·Li there: in a constant environment without any variance. Light is found only
/// by running into it. Roulette on throughput·η², as in path().
void cosine(Trace& trace, std::span<CameraSample> samples);

}  // namespace tessera::render
