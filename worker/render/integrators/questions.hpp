#pragma once
#include <array>
#include <cstddef>

#include "worker/render/at_once.hpp"
#include "worker/render/bsdf/bsdf_batch.hpp"
#include "worker/render/lights/light_table.hpp"

namespace tessera::render {

/// What samples that go side by side ask together, and the answers.
struct Questions {
  template <class T>
  using OfEach = std::array<T, samples_at_once>;

  OfEach<LightRequest> light_requests;
  OfEach<LightSample> lights;
  OfEach<ScatteringRequest> scatterings;
  OfEach<std::size_t> places{};  ///< whose light scattering is asked for
  OfEach<Scattering> scattered;
  OfEach<BsdfRequest> bsdf_requests;
  OfEach<float> roulette{};
  OfEach<BsdfSample> drawn;
  BsdfBatch batch;
};

}  // namespace tessera::render
