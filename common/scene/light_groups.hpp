#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "common/scene/description.hpp"

/// Light groups: whose light stands in an output of its own.
namespace tessera::scene {

/// The scene's groups, each once: the default group, then the others in alphabetical order.
std::vector<std::string> light_groups(const Scene& scene);

/// Throws Error{bad_input} at `render.aovs` if one of these AOVs is of a light group that is not in
/// `groups`.
void check_light_groups(const std::vector<std::string>& aovs,
                        const std::vector<std::string>& groups);

}  // namespace tessera::scene
