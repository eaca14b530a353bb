#pragma once

namespace tessera::render {

/// What random numbers cost, each figure beside the same of the default within one run (medians of
/// interleaved rounds, CPU time of one thread): a number of each sampler as the renderer asks for
/// it, by address; a number of each generator as a stream that is seeded once, which is how the
/// founding report drew them; a sample of the Cornell box by each sampler, and by each integrator.
/// Prints lines "name value unit".
void print_sampler_ratios();

}  // namespace tessera::render
