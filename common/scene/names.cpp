#include "common/scene/names.hpp"

#include <string>

#include "common/base/error.hpp"
#include "common/base/names.hpp"

namespace tessera::scene {

void check_name(std::string_view kind, std::string_view name,
                const std::vector<std::string_view>& names, std::string_view key) {
  for (const std::string_view known : names)
    if (name == known) return;
  throw Error(ErrorKind::bad_input, unknown_name(kind, name, names), {.key = std::string(key)});
}

void check_names(const RenderSettings& render) {
  check_name("integrator", render.integrator, {integrator_names.begin(), integrator_names.end()},
             "integrator");
  check_name("sampler", render.sampler, {sampler_names.begin(), sampler_names.end()}, "sampler");
  check_name("filter", render.filter, {filter_names.begin(), filter_names.end()}, "filter");
}

}  // namespace tessera::scene
