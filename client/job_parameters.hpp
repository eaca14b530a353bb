#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "client/job_options.hpp"
#include "common/base/json.hpp"

/// The parameters of a job by name, for whoever sets one that a person named. Pure.
namespace tessera::client {

struct JobParameter {
  std::string_view name;  ///< the flag's, with underscores
  bool (*given)(const JobOptions& job);
  /// Throws Error{bad_input} without a place for a value of another kind. What values are allowed
  /// is job_from's matter.
  void (*set)(JobOptions& job, const Json& value);
};

const std::vector<JobParameter>& job_parameters();

/// The job's parameter of this name: as its flag ("light_samples", "light-samples") or as the place
/// in a scene that says the same ("render.light_samples", "film.width"). Nothing if there is none.
const JobParameter* find_job_parameter(std::string_view name);

}  // namespace tessera::client
