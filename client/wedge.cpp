#include <fmt/format.h>

#include <csignal>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "client/commands.hpp"
#include "client/farm.hpp"
#include "client/follow.hpp"
#include "client/output.hpp"
#include "client/post.hpp"
#include "client/print.hpp"
#include "client/sheet.hpp"
#include "client/upload.hpp"
#include "client/wedge_sheet.hpp"
#include "common/base/error.hpp"
#include "common/base/files.hpp"

namespace tessera::client {

namespace fs = std::filesystem;

namespace {

constexpr int workers_unless_asked = 1;

/// Whether it renders on a farm of its own: if no server is named, or one is set for good but this
/// command line asks for workers.
bool on_own_farm(const Settings& settings, const WedgeOptions& options) {
  const bool asked = options.workers || options.threads;
  return settings.named == NamedBy::nobody || (asked && settings.named != NamedBy::flag);
}

Look look_of(const WedgeOptions& options) {
  return {.exposure = options.exposure, .view = view_from(options.view)};
}

void check_options(const Settings& settings, const WedgeOptions& options) {
  (void)look_of(options);
  if (check_output(options.output) != PictureFormat::png)
    throw Error(ErrorKind::bad_input, "a contact sheet is a .png", {.file = {}, .key = "--output"});
  if ((options.workers || options.threads) && !on_own_farm(settings, options))
    throw Error(ErrorKind::bad_input,
                "is for a farm of the command's own, and cannot stand beside --server",
                {.file = {}, .key = options.workers ? "--workers" : "--threads"});
}

/// The folder for the EXRs, made if it is not there.
fs::path exr_folder(const WedgeOptions& options) {
  fs::path folder = options.exr_dir;
  if (folder.empty()) folder = fs::path(options.output).replace_extension();
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || !fs::is_directory(folder, error))
    throw Error(ErrorKind::bad_input,
                fmt::format("the folder \"{}\" cannot be made{}", folder.string(),
                            error ? ": " + error.message() : ""),
                {.file = {}, .key = "--exr-dir"});
  return folder;
}

/// A wedge's jobs on a server, from the first upload to the last picture.
class Jobs {
 public:
  Jobs(Server& server, const WedgePlan& plan, const PreparedWedge& prepared, const fs::path& folder)
      : server_(server), plan_(plan), prepared_(prepared), states_(prepared.jobs.size()) {
    for (const std::string& name : exr_names(plan)) files_.push_back(folder / name);
  }

  void submit(ProgressPrinter& printer) {
    for (const SceneAssets& scene : prepared_.scenes)
      upload(server_, scene, [&](std::uint64_t done, std::uint64_t total) {
        printer.remark_now_and_then(upload_text(done, total));
      });
    ids_.reserve(prepared_.jobs.size());
    for (std::size_t i = 0; i < prepared_.jobs.size(); ++i) {
      states_[i] = job_state_from(post_job(server_, prepared_.jobs[i]));
      ids_.push_back(states_[i].id);
    }
  }

  /// Until all have ended; each picture is fetched as soon as it is whole.
  void follow_to_the_end(ProgressPrinter& printer, const std::function<void()>& check) {
    const auto start = std::chrono::steady_clock::now();
    const auto changed = [&](std::size_t index, const Json& object) {
      states_[index] = job_state_from(object);
      if (states_[index].state == "done") fetch(index);
      if (states_[index].ended()) ++ended_;
      JobState all = overall(states_);
      all.render_seconds = seconds(std::chrono::steady_clock::now() - start);
      printer.show(all, fmt::format("{}/{} pictures  ", ended_, ids_.size()));
    };
    follow(server_, ids_, changed, {.check = check});
  }

  /// Those that have not ended, on a server that goes on without us.
  void cancel() {
    std::vector<JobId> open;
    for (std::size_t i = 0; i < ids_.size(); ++i)
      if (!states_[i].ended()) open.push_back(ids_[i]);
    cancel_posted(server_, open);
  }

  /// Says which did not come out, and gives the command's exit code.
  [[nodiscard]] int outcome() const {
    int code = 0;
    for (std::size_t i = 0; i < states_.size(); ++i) {
      if (states_[i].state == "done") continue;
      fmt::print(stderr, "tessera: {}: {}\n", text_of(plan_, plan_.cells[i]), end_text(states_[i]));
      code = exit_code(ErrorKind::failed);
    }
    return code;
  }

  void draw(Sheet& sheet, const WedgeOptions& options) const {
    for (std::size_t i = 0; i < states_.size(); ++i) {
      throw_if_interrupted();
      if (states_[i].state == "done")
        sheet.place(i, image::read_exr_file(files_[i]), options.cell_width, look_of(options));
      else
        sheet.place_words(i, states_[i].state);
    }
  }

  [[nodiscard]] Json report() const {
    Json out = Json::array();
    for (std::size_t i = 0; i < states_.size(); ++i) {
      const JobState& job = states_[i];
      const WedgeCell& cell = plan_.cells[i];
      out.push_back({{"parameters", parameters_of(plan_, cell)},
                     {"column", cell.column},
                     {"row", cell.row},
                     {"block", cell.block},
                     {"job", job.id},
                     {"state", job.state},
                     {"error", job.error.empty() ? Json() : Json(job.error)},
                     {"exr", job.state == "done" ? Json(files_[i].string()) : Json()},
                     {"width", prepared_.jobs[i].render.width},
                     {"height", prepared_.jobs[i].render.height},
                     {"samples", job.samples},
                     {"rays", job.rays},
                     {"render_seconds", job.render_seconds},
                     {"cpu_seconds", job.cpu_seconds}});
    }
    return out;
  }

 private:
  void fetch(std::size_t index) {
    fetch_picture(server_,
                  picture_target(ids_[index], states_[index].first_frame, PictureFormat::exr, 0),
                  files_[index]);
  }

  Server& server_;
  const WedgePlan& plan_;
  const PreparedWedge& prepared_;
  std::vector<JobState> states_;
  std::vector<JobId> ids_;
  std::vector<fs::path> files_;
  std::size_t ended_ = 0;
};

void run_jobs(Jobs& jobs, Farm* farm) {
  ProgressPrinter printer(2);
  try {
    jobs.submit(printer);
    jobs.follow_to_the_end(printer, [&] {
      if (farm != nullptr) farm->check(printer);
    });
  } catch (const Error& error) {
    printer.finish();
    if (farm == nullptr) jobs.cancel();
    // The reason rather than the symptom.
    if (farm != nullptr && error.kind() == ErrorKind::unreachable) farm->check(printer);
    throw;
  } catch (const Interrupted&) {
    printer.finish();
    if (farm == nullptr) jobs.cancel();
    throw;
  }
}

}  // namespace

int wedge(const Settings& settings, const WedgeOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  check_options(settings, options);
  std::vector<Vary> axes;
  for (const std::string& text : options.vary) axes.push_back(vary_from(text));
  const WedgePlan plan = plan_wedge(options.job, std::move(axes));
  const PreparedWedge prepared = prepare_wedge(plan);
  print_warnings(prepared.warnings);
  const SheetContent content = content_of(plan, prepared, options.cell_width, look_of(options));
  const SheetLayout layout = lay_out(content);
  const fs::path folder = exr_folder(options);
  std::signal(SIGPIPE, SIG_IGN);  // if nobody reads the progress, the pictures are still wanted

  const int workers = options.workers.value_or(workers_unless_asked);
  const int threads = threads_of_each(options.threads.value_or(0), workers);
  std::optional<Farm> farm;
  if (on_own_farm(settings, options)) farm.emplace(workers, threads);
  Server server(farm ? Settings{.server = farm->url(), .token = {}} : settings);
  Jobs jobs(server, plan, prepared, folder);
  run_jobs(jobs, farm ? &*farm : nullptr);
  Sheet sheet(layout, content.cell_width, content.cell_height);
  jobs.draw(sheet, options);
  write_file_atomically(options.output, sheet.png());
  const double total = seconds(std::chrono::steady_clock::now() - start);
  if (settings.json)
    print_json({{"output", options.output.string()},
                {"exr_dir", folder.string()},
                {"seconds", total},
                {"columns", plan.columns},
                {"rows", plan.rows},
                {"blocks", plan.blocks},
                {"cells", jobs.report()}});
  else
    fmt::print("{}: {} by {} pictures{}, {:.1f} s; each as EXR in {}\n", options.output.string(),
               plan.columns, plan.rows,
               plan.blocks > 1 ? fmt::format(" in {} blocks", plan.blocks) : "", total,
               folder.string());
  return jobs.outcome();
}

}  // namespace tessera::client
