#include "worker/render/sampler.hpp"

#include "common/base/error.hpp"
#include "common/base/names.hpp"

namespace tessera::render {

namespace {

struct Entry {
  std::string_view name;
  SamplerKind kind;
};
/// Every sampler there is. The next one: a file with its draw, a kind, a case in Sampler::draw_at,
/// a line here.
constexpr Entry samplers[] = {
    {"sobol_owen", SamplerKind::sobol_owen},
    {"independent", SamplerKind::independent},
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

}  // namespace tessera::render
