// A job as it is posted: its text, its values, and what they come to.
#include "common/base/json.hpp"
#include "common/base/limits.hpp"
#include "common/job/job_spec.hpp"

#include <nlohmann/json.hpp>

#include "tests/fuzz/target.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tessera;
  fuzz::take_or_refuse([&] {
    const JobSpec spec = job_spec_from_json(parse_json(fuzz::text_of(data, size), "job"));
    fuzz::require(job_spec_from_json(to_json(spec)) == spec,
                  "a job is the same when it is written and read again");
    const JobPlan plan(spec);
    fuzz::require(plan.tasks() > 0 && plan.tasks() <= limits::tasks_max,
                  "a job has tasks, and not too many");
  });
  return 0;
}
