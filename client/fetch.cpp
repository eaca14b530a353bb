#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "client/commands.hpp"
#include "client/follow.hpp"
#include "client/output.hpp"
#include "client/print.hpp"

namespace tessera::client {

int fetch(const Settings& settings, const FetchOptions& options) {
  const PictureFormat format = check_output(options.output);
  Server server(settings);
  const JobState job = job_state_from(fetch_job(server, options.job));
  const std::int64_t frame = options.frame.value_or(static_cast<std::int32_t>(job.first_frame));
  fetch_picture(server, picture_target(options.job, frame, format, options.exposure),
                options.output);
  if (settings.json) {
    print_json({{"output", options.output.string()},
                {"job", job.id},
                {"frame", frame},
                {"state", job.state},
                {"progress", job.progress}});
  } else if (job.state != "done") {
    fmt::print(stderr, "tessera: the picture so far: job {} is {} at {:.1f} %\n", job.id, job.state,
               job.progress * 100);
  }
  return 0;
}

}  // namespace tessera::client
