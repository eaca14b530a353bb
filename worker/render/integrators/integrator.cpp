#include "worker/render/integrators/integrator.hpp"

#include <array>

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "worker/render/integrators/cosine.hpp"
#include "worker/render/integrators/hemisphere.hpp"
#include "worker/render/integrators/hemisphere_lights.hpp"
#include "worker/render/integrators/path.hpp"

namespace tessera::render {
namespace {

struct Entry {
  std::string_view name;
  Integrator function;
};
/// Every integrator there is. The next one: a file, a line here, its name in common/scene.
constexpr std::array table{
    Entry{"path", path},
    Entry{"cosine", cosine},
    Entry{"hemisphere_lights", hemisphere_lights},
    Entry{"hemisphere", hemisphere},
};

}  // namespace

Integrator integrator(std::string_view name) {
  for (const Entry& entry : table) {
    if (entry.name == name) return entry.function;
  }
  throw Error(ErrorKind::bad_input, unknown_name("integrator", name, integrator_names()));
}

std::vector<std::string_view> integrator_names() {
  std::vector<std::string_view> names;
  names.reserve(table.size());
  for (const Entry& entry : table) names.push_back(entry.name);
  return names;
}

}  // namespace tessera::render
