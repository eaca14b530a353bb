#pragma once
#include <array>
#include <string_view>
#include <vector>

#include "common/job/job_spec.hpp"

/// The names by which a scene and a command line choose how to render. The renderer's tables hold
/// what they mean, and a test compares the two: whoever adds an integrator, a sampler or a filter
/// adds its name here.
namespace tessera::scene {

inline constexpr std::array<std::string_view, 4> integrator_names{
    "path", "cosine", "hemisphere_lights", "hemisphere"};
inline constexpr std::array<std::string_view, 6> sampler_names{
    "sobol_owen", "sobol", "independent", "pcg", "xorshift", "mt19937"};
inline constexpr std::array<std::string_view, 4> filter_names{"box", "tent", "gaussian",
                                                              "blackman_harris"};

/// Throws Error{bad_input} that names the nearest, at the key `key`, if `name` is not in `names`.
void check_name(std::string_view kind, std::string_view name,
                const std::vector<std::string_view>& names, std::string_view key);
/// The three names of `render`; keys are "integrator", "sampler", "filter".
void check_names(const RenderSettings& render);

}  // namespace tessera::scene
