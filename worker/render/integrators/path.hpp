#pragma once
#include "worker/render/integrators/integrator.hpp"

namespace tessera::render {

/// Path tracing with next-event estimation at every hit that is not a mere mirror, multiple
/// importance sampling by the power heuristic (Veach 1997), and roulette on throughput·η². A hit at
/// depth d (the camera's is 0) scatters if d ≤ bounces; the hit after that is looked at for its
/// emission only.
void path(Trace& trace, std::span<CameraSample> samples);

}  // namespace tessera::render
