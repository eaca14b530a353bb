#include "server/http/views.hpp"

#include <fmt/format.h>

#include <chrono>
#include <nlohmann/json.hpp>

namespace tessera::server {

namespace {
Json time_or_null(UnixMillis time) { return time == 0 ? Json() : Json(iso_time(time)); }

/// `step` where they are one range; `ranges` always.
Json frames_object(const FrameList& frames) {
  Json ranges = Json::array();
  for (const FrameRange& range : frames.ranges)
    ranges.push_back({{"first", range.first}, {"last", range.last}, {"step", range.step}});
  const bool single = frames.ranges.size() == 1;
  return {{"first", frames.first()},
          {"last", single ? frames.ranges.front().last : frames.last()},
          {"step", single ? Json(frames.ranges.front().step) : Json()},
          {"count", frames.count()},
          {"ranges", std::move(ranges)}};
}

Json shares_array(const JobStatus& status) {
  Json shares = Json::array();
  for (const JobStatus::Share& share : status.shares)
    shares.push_back({{"worker", share.worker}, {"samples", share.samples}});
  return shares;
}
}  // namespace

std::string iso_time(UnixMillis time) {
  using std::chrono::floor;
  const std::chrono::sys_time<std::chrono::milliseconds> instant{std::chrono::milliseconds(time)};
  const auto day = floor<std::chrono::days>(instant);
  const std::chrono::year_month_day date(day);
  const std::chrono::hh_mm_ss clock(instant - day);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:03}Z", static_cast<int>(date.year()),
                     static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                     clock.hours().count(), clock.minutes().count(), clock.seconds().count(),
                     clock.subseconds().count());
}

Json job_object(const JobStatus& status) {
  const JobSpec& spec = status.plan->spec;
  const JobView& view = status.view;
  Json job = {{"id", view.id},
              {"name", spec.name},
              {"state", view.state},
              {"priority", view.priority},
              {"max_workers", spec.max_workers},
              {"order", name_of(spec.order)},
              {"focus", spec.focus ? to_json(*spec.focus) : Json()},
              {"time_limit_seconds", spec.time_limit_seconds},
              {"noise_threshold", spec.noise_threshold},
              {"frames", frames_object(spec.frames)},
              {"fps", spec.fps},
              {"frames_done", status.frames_done},
              {"width", spec.render.width},
              {"height", spec.render.height},
              {"pixel_aspect", spec.render.pixel_aspect},
              {"crop", spec.render.crop ? to_json(*spec.render.crop) : Json()},
              {"tile", spec.tile},
              {"samples", spec.render.samples},
              {"progress", status.progress},
              {"samples_done", view.samples_done},
              {"samples_total", view.samples},
              {"tasks", view.tasks},
              {"tasks_done", view.tasks_done},
              {"tasks_leased", view.leased},
              {"samples_per_second", view.samples_per_second}};
  job["created"] = time_or_null(status.created);
  job["started"] = time_or_null(status.started);
  job["finished"] = time_or_null(status.finished);
  const auto seconds_or_null = [](const std::optional<double>& value) {
    return value ? Json(*value) : Json();
  };
  job["eta_seconds"] = seconds_or_null(view.eta_seconds);
  job["eta_low_seconds"] = seconds_or_null(view.eta_low_seconds);
  job["eta_high_seconds"] = seconds_or_null(view.eta_high_seconds);
  job["render_seconds"] = status.render_seconds;
  job["cpu_seconds"] = status.cpu_seconds;
  job["rays"] = status.rays;
  job["rejected_samples"] = status.rejected_samples;
  job["failures"] = status.failures;
  job["shares"] = shares_array(status);
  job["error"] = view.error.empty() ? Json() : Json(view.error);
  job["waiting_for"] = view.waiting_for.empty() ? Json() : Json(view.waiting_for);
  job["extended_from"] = status.extended_from;
  job["shortened_from"] = status.shortened_from > 0 ? Json(status.shortened_from) : Json();
  job["frames_shortened"] = status.frames_shortened;
  job["bundle"] = spec.bundle.hex();
  job["plan"] = status.plan->digest.hex();
  job["build"] = view.build ? Json(view.build->hex()) : Json();
  return job;
}

Json failure_object(const FailureRecord& failure, const TileGrid& grid) {
  Json out = {{"number", failure.number},
              {"frame", nullptr},
              {"tile", nullptr},
              {"pass", nullptr},
              {"window", nullptr},
              {"worker", failure.worker_name},
              {"worker_id", failure.worker},
              {"started", time_or_null(failure.started)},
              {"ended", time_or_null(failure.ended)},
              {"outcome", failure.outcome},
              {"reason", failure.reason},
              {"log", failure.log.empty() ? Json() : Json(failure.log)}};
  if (!failure.task) return out;
  out["frame"] = failure.task->frame;
  out["tile"] = failure.task->tile;
  out["pass"] = failure.task->pass;
  if (failure.task->tile >= grid.count()) return out;
  const Rect window = grid.tile(failure.task->tile);
  out["window"] = {
      {"x", window.x}, {"y", window.y}, {"width", window.width}, {"height", window.height}};
  return out;
}

Json quarantine_object(const Quarantine& quarantine) {
  return {{"name", quarantine.name},
          {"reason", quarantine.reason},
          {"by", quarantine.by},
          {"since", time_or_null(quarantine.since)},
          {"durable", quarantine.durable}};
}

Json worker_object(const WorkerView& worker, const Quarantine* quarantine) {
  // The identity is left out: who knows it could speak in the worker's name.
  return {{"id", worker.id},
          {"name", worker.info.name},
          {"threads", worker.info.threads},
          {"build", worker.info.build_id.hex()},
          {"state", worker.state},
          {"reason", worker.reason.empty() ? Json() : Json(worker.reason)},
          {"quarantine", quarantine == nullptr ? Json() : quarantine_object(*quarantine)},
          {"leases", worker.leases},
          {"tasks_done", worker.tasks_done},
          {"samples_per_second", worker.samples_per_second},
          {"silent_seconds", worker.silent_seconds}};
}

}  // namespace tessera::server
