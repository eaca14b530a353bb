#include "client/job_parameters.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <type_traits>

#include "common/base/error.hpp"
#include "common/base/names.hpp"

namespace tessera::client {

namespace {

[[noreturn]] void expected(std::string_view what, const Json& value) {
  throw Error(ErrorKind::bad_input,
              fmt::format("expected {}, found {}", what, excerpt(value.dump())));
}

/// 64 and 64.0 and 1e3 are whole numbers.
template <class Whole>
Whole whole_from(const Json& value) {
  constexpr std::string_view what = "a whole number";
  if (!value.is_number()) expected(what, value);
  // What does not fit a double's 53 bits came as an integer, so this loses nothing that counts.
  const auto number = value.get<double>();
  constexpr auto low = static_cast<double>(std::numeric_limits<Whole>::min());
  const auto high = std::ldexp(1.0, std::numeric_limits<Whole>::digits);
  if (!(number >= low && number < high) || number != std::floor(number)) expected(what, value);
  return value.is_number_integer() ? value.get<Whole>() : static_cast<Whole>(number);
}

template <class Member>
Member member_from(const Json& value) {
  if constexpr (std::is_same_v<Member, std::string>) {
    if (!value.is_string()) expected("a name", value);
    return value.get<std::string>();
  } else if constexpr (std::is_same_v<Member, double>) {
    if (!value.is_number()) expected("a number", value);
    return value.get<double>();
  } else {
    return whole_from<Member>(value);
  }
}

template <auto member>
constexpr JobParameter parameter(std::string_view name) {
  return {name, [](const JobOptions& job) { return (job.*member).has_value(); },
          [](JobOptions& job, const Json& value) {
            using Value = typename std::remove_reference_t<decltype(job.*member)>::value_type;
            job.*member = member_from<Value>(value);
          }};
}

bool size_given(const JobOptions& job) { return job.width || job.height; }

void set_size(JobOptions& job, const Json& value) {
  if (!value.is_string()) expected("WIDTHxHEIGHT", value);
  try {
    const Size size = size_from(value.get<std::string>());
    job.width = size.width;
    job.height = size.height;
  } catch (const Error& error) {
    throw Error(error.kind(), error.message());
  }
}

}  // namespace

const std::vector<JobParameter>& job_parameters() {
  static const std::vector<JobParameter> table{
      parameter<&JobOptions::samples>("samples"),
      parameter<&JobOptions::light_samples>("light_samples"),
      parameter<&JobOptions::bounces>("bounces"),
      parameter<&JobOptions::integrator>("integrator"),
      parameter<&JobOptions::sampler>("sampler"),
      parameter<&JobOptions::clamp_direct>("clamp_direct"),
      parameter<&JobOptions::clamp_indirect>("clamp_indirect"),
      parameter<&JobOptions::seed>("seed"),
      parameter<&JobOptions::filter>("filter"),
      parameter<&JobOptions::filter_width>("filter_width"),
      {"size", size_given, set_size},
      parameter<&JobOptions::width>("width"),
      parameter<&JobOptions::height>("height"),
      parameter<&JobOptions::camera>("camera"),
      parameter<&JobOptions::fps>("fps"),
      parameter<&JobOptions::tile>("tile"),
      parameter<&JobOptions::pass>("pass"),
  };
  return table;
}

const JobParameter* find_job_parameter(std::string_view name) {
  constexpr std::string_view render = "render.", film = "film.";
  std::string key(name);
  if (name.starts_with(render)) {
    key = name.substr(render.size());
    // These are no keys of "render", so such a path is the scene's matter, to refuse.
    for (const std::string_view other :
         {"size", "width", "height", "camera", "fps", "tile", "pass"})
      if (key == other) return nullptr;
  } else if (name == "film.width" || name == "film.height") {
    key = name.substr(film.size());
  } else {
    std::replace(key.begin(), key.end(), '-', '_');
  }
  for (const JobParameter& one : job_parameters())
    if (one.name == key) return &one;
  return nullptr;
}

}  // namespace tessera::client
