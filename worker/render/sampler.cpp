#include "worker/render/sampler.hpp"

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "worker/render/sampler_independent.hpp"
#include "worker/render/sampler_mt19937.hpp"
#include "worker/render/sampler_pcg.hpp"
#include "worker/render/sampler_xorshift.hpp"

namespace tessera::render {

namespace {

struct Entry {
  std::string_view name;
  SamplerKind kind;
};
/// Every sampler there is. The next one: a file with its draw, a kind, a case in addressed_draw(),
/// a line here.
constexpr Entry samplers[] = {
    {"sobol_owen", SamplerKind::sobol_owen},   {"sobol", SamplerKind::sobol},
    {"independent", SamplerKind::independent}, {"pcg", SamplerKind::pcg},
    {"xorshift", SamplerKind::xorshift},       {"mt19937", SamplerKind::mt19937},
};

}  // namespace

SamplerKind sampler_kind(std::string_view name) {
  for (const Entry& entry : samplers) {
    if (entry.name == name) return entry.kind;
  }
  throw Error(ErrorKind::bad_input, unknown_name("sampler", name, sampler_names()));
}

std::vector<std::string_view> sampler_names() {
  std::vector<std::string_view> names;
  for (const Entry& entry : samplers) names.push_back(entry.name);
  return names;
}

std::array<std::uint32_t, 4> addressed_draw(SamplerKind kind, std::uint64_t pixel_hash,
                                            std::uint32_t set, std::uint64_t index) {
  switch (kind) {
    case SamplerKind::sobol_owen:
      break;
    case SamplerKind::sobol:
      return sobol_draw(pixel_hash, set, index);
    case SamplerKind::independent:
      return independent_draw(pixel_hash, set, index);
    case SamplerKind::pcg:
      return pcg_draw(pixel_hash, set, index);
    case SamplerKind::xorshift:
      return xorshift_draw(pixel_hash, set, index);
    case SamplerKind::mt19937:
      return mt19937_draw(pixel_hash, set, index);
  }
  return sobol_owen_draw(pixel_hash, set, index);
}

}  // namespace tessera::render
