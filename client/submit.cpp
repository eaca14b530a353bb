#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "client/commands.hpp"
#include "client/interrupt.hpp"
#include "client/post.hpp"
#include "client/prepare.hpp"
#include "client/print.hpp"
#include "client/progress.hpp"
#include "client/upload.hpp"

namespace tessera::client {

int submit(const Settings& settings, const JobOptions& options) {
  const PreparedJob prepared = prepare(options);
  print_warnings(prepared.warnings);
  Server server(settings);
  ProgressPrinter printer(2);
  const UploadSummary sent =
      upload(server, prepared.assets, [&](std::uint64_t done, std::uint64_t total) {
        printer.remark_now_and_then(upload_text(done, total));
      });
  printer.say(sent_text(sent.files, sent.bytes, assets::blob_size(prepared.assets.bundle)));
  const Json job = post_job(server, prepared.spec);
  if (interrupted()) {
    cancel_posted(server, {job_state_from(job).id});
    throw Interrupted{};
  }
  if (settings.json)
    print_json(job);
  else
    fmt::print("{}\n", job_state_from(job).id);
  return 0;
}

}  // namespace tessera::client
