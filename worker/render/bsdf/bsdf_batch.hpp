#pragma once
#include <array>
#include <cstddef>
#include <span>

#include "worker/render/at_once.hpp"
#include "worker/render/bsdf/bsdf.hpp"
#include "worker/render/bsdf/microfacet.hpp"

namespace tessera::render {

/// Answers what many hits ask at once, in less time for each than sample() and scattering(), with
/// the same bits: what their microfacets do goes side by side. found[i] answers asked[i]. For one
/// thread; made once for many calls, as to make one takes time too.
class BsdfBatch {
 public:
  /// At most samples_at_once requests each.
  void sample(std::span<const BsdfRequest> asked, std::span<BsdfSample> found);
  void scattering(std::span<const ScatteringRequest> asked, std::span<Scattering> found);

 private:
  /// What waits for its lobes' parts.
  struct Sum {
    const Closure* closure = nullptr;
    Scattering* out = nullptr;
    std::size_t first = 0;  ///< of the parts
  };
  /// `out` is written now or by answer().
  void add(const ScatteringRequest& request, Scattering& out);
  void answer();

  std::size_t count_ = 0, used_ = 0, waiting_count_ = 0;
  std::array<Sum, samples_at_once> sums_;
  std::array<Scattering, samples_at_once * 4> parts_;  ///< whoever finds no room is answered alone
  std::array<Scattering, samples_at_once> weights_;
  std::array<std::size_t, samples_at_once> waiting_{};
  microfacet::Batch microfacets_;
};

}  // namespace tessera::render
