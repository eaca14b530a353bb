#include "server/coordinator/job_table.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "server/schedule/noise_stop.hpp"

namespace tessera::server {

namespace {

JobPlan plan_of(const JobRecord& record) {
  JobSpec spec = record.spec;
  spec.priority = record.priority;
  return JobPlan(spec);
}

std::string text_of(const nlohmann::json& json) {
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

bool is_end(const std::string& state) {
  return state == "done" || state == "failed" || state == "cancelled";
}

SamplesOfFrames samples_of_frames(const Job& job) {
  const std::int64_t all = job.plan->passes.samples();
  const auto& shortened = job.record.shortened_frames;
  // Of what no frame is shortened to, unless all are.
  const bool some_has_all = shortened.size() < job.plan->spec.frames.count();
  SamplesOfFrames found{all, some_has_all ? all : 0};
  for (const auto& [frame, samples] : shortened) {
    found.fewest = std::min(found.fewest, samples);
    found.most = std::max(found.most, samples);
  }
  return found;
}

std::uint64_t final_version(const Job& job) {
  return job.version_base + static_cast<std::uint64_t>(job.plan->tasks_per_frame());
}

Job::Job(JobRecord from, Instant now, UnixMillis wall_now)
    : record(std::move(from)),
      plan(std::make_shared<const JobPlan>(plan_of(record))),
      ended(is_end(record.state)) {
  for (const std::int64_t samples : record.extended_from) {
    JobSpec before = plan->spec;
    before.render.samples = samples;
    const JobPlan earlier(before);
    // Where all frames ended before the samples asked for, it may have been extended to just these.
    if (earlier.digest != plan->digest) earlier_plans.push_back(earlier.digest);
    version_base += static_cast<std::uint64_t>(earlier.tasks_per_frame()) + 1;
  }
  if (record.shortened_from > 0) {
    // What was rendered before its time was up is of this plan; results of it may still come.
    JobSpec asked = plan->spec;
    asked.render.samples = record.shortened_from;
    const Digest digest = JobPlan(asked).digest;
    if (digest != plan->digest) earlier_plans.push_back(digest);  // it may have been extended to it
  }
  if (ended) {
    for (const JobRecord::Share& share : record.shares) shares[share.worker] += share.samples;
    return;
  }
  earlier_seconds = record.render_seconds;
  // Counted anew from the results that are read back.
  record.rays = 0;
  record.cpu_seconds = 0;
  record.rejected_samples = 0;
  record.shares.clear();
  if (record.started == 0) return;
  first_lease = now - std::chrono::milliseconds(std::max<UnixMillis>(0, wall_now - record.started));
  last_fold = now;  // the latest that it can have been; the time between two runs counts
}

void Job::has_ended_as(const JobRecord& kept) {
  auto shortened_frames = std::move(record.shortened_frames);
  record = kept;
  record.shortened_frames = std::move(shortened_frames);
}

void Job::spec_changed() { plan = std::make_shared<const JobPlan>(plan_of(record)); }

bool Job::awaits_noise(const Digest& of_plan) const {
  // Not at its `ending`: a cancel that the disk refuses is none, and nobody asks again.
  if (ended || broken || plan->digest != of_plan) return false;
  // A job that goes on to more samples has none any more, and its plan may be the same.
  return plan->spec.noise_threshold > 0;
}

void Job::count(const std::string& worker, std::int64_t samples, std::int64_t rays,
                std::int64_t rejected, double cpu_seconds, const Digest& worker_build) {
  shares[worker] += samples;
  record.rays += rays;
  record.cpu_seconds += cpu_seconds;
  record.rejected_samples += rejected;
  if (!build) build = worker_build;
}

double Job::render_seconds(Instant now, bool leased) const {
  if (ended) return record.render_seconds;
  if (!first_lease) return earlier_seconds;
  if (leased && !ending) return earlier_seconds + seconds(now - *first_lease);
  return earlier_seconds + (last_fold ? seconds(*last_fold - *first_lease) : 0);
}

std::int64_t Job::samples_total() const {
  std::int64_t samples = plan->passes.samples() * plan->spec.frames.count();
  for (const auto& [frame, fewer] : record.shortened_frames)
    samples -= plan->passes.samples() - fewer;
  return plan->grid.window().pixels() * samples;
}

std::int64_t Job::tasks_total() const {
  std::int64_t passes = std::int64_t{plan->passes.count()} * plan->spec.frames.count();
  for (const auto& [frame, fewer] : record.shortened_frames)
    passes -= plan->passes.count() - passes_within(plan->passes, fewer);
  return plan->grid.count() * passes;
}

std::int64_t Job::samples_of(std::int32_t frame) const {
  const auto fewer = record.shortened_frames.find(frame);
  return fewer == record.shortened_frames.end() ? plan->passes.samples() : fewer->second;
}

std::uint32_t Job::passes_of(std::int32_t frame) const {
  return passes_within(plan->passes, samples_of(frame));
}

std::vector<JobRecord::Share> Job::shares_by_size() const {
  std::vector<JobRecord::Share> sorted;
  sorted.reserve(shares.size());
  for (const auto& [worker, samples] : shares) sorted.push_back({worker, samples});
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto& a, const auto& b) { return a.samples > b.samples; });
  return sorted;
}

JobRecord Job::end_record(const std::string& state, const std::string& error, Instant now,
                          UnixMillis wall_now) const {
  JobRecord last = record;
  last.state = state;
  last.error = error;
  last.finished = wall_now;
  last.render_seconds = render_seconds(now, false);
  last.shares = shares_by_size();
  return last;
}

JobStatus Job::status(const std::optional<JobView>& view, Instant now) const {
  JobStatus status;
  if (view) {
    status.view = *view;
    if (ended || extending) {
      // Between its two plans the scheduler has let go of the job, which is nobody's business.
      status.view.state = record.state;
    } else if (broken && ending) {
      status.view.state = "failed";
      status.view.error = unreadable;
    } else if (view->state == "done") {
      status.view.state = "rendering";
    }
  } else {
    status.view.id = record.id;
    status.view.state = record.state;
    status.view.tasks = tasks_total();
    status.view.samples = samples_total();
    for (const auto& [worker, samples] : shares) status.view.samples_done += samples;
    if (record.state == "done") status.view.samples_done = status.view.samples;
    if (record.state == "done") status.view.tasks_done = status.view.tasks;
  }
  if (!record.error.empty()) status.view.error = record.error;
  status.view.priority = record.priority;
  status.view.build = build ? build : status.view.build;
  status.plan = plan;
  status.frames_done = static_cast<std::uint32_t>(files.size());
  status.created = record.created;
  status.started = record.started;
  status.finished = record.finished;
  status.progress = status.view.samples > 0 ? static_cast<double>(status.view.samples_done) /
                                                  static_cast<double>(status.view.samples)
                                            : 0;
  status.render_seconds = render_seconds(now, view && view->leased > 0);
  status.cpu_seconds = record.cpu_seconds;
  status.rays = record.rays;
  status.rejected_samples = record.rejected_samples;
  status.failures = failures;
  status.extended_from = record.extended_from;
  status.shortened_from = record.shortened_from;
  status.frames_shortened = static_cast<std::uint32_t>(record.shortened_frames.size());
  for (const JobRecord::Share& share : shares_by_size())
    status.shares.push_back({share.worker, share.samples});
  return status;
}

std::string job_event(const JobStatus& status) {
  const auto seconds_or_null = [](const std::optional<double>& value) {
    return value ? nlohmann::json(*value) : nlohmann::json();
  };
  nlohmann::json waiting_for = nullptr;
  if (!status.view.waiting_for.empty()) waiting_for = status.view.waiting_for;
  nlohmann::json error = nullptr;
  if (!status.view.error.empty()) error = status.view.error;
  return text_of({{"id", status.view.id},
                  {"name", status.plan->spec.name},
                  {"state", status.view.state},
                  {"priority", status.view.priority},
                  {"progress", status.progress},
                  {"samples_done", status.view.samples_done},
                  {"samples_total", status.view.samples},
                  {"samples_per_second", status.view.samples_per_second},
                  {"eta_seconds", seconds_or_null(status.view.eta_seconds)},
                  {"eta_low_seconds", seconds_or_null(status.view.eta_low_seconds)},
                  {"eta_high_seconds", seconds_or_null(status.view.eta_high_seconds)},
                  {"failures", status.failures},
                  {"waiting_for", waiting_for},
                  {"error", error}});
}

std::string removed_event(const Job& job) {
  return text_of({{"id", job.record.id}, {"name", job.record.spec.name}});
}

std::string frame_event(JobId job, std::int32_t frame, std::uint64_t version) {
  return text_of({{"job", job}, {"frame", frame}, {"version", version}});
}

std::string worker_event(WorkerId worker, const std::string& name, const char* state) {
  return text_of({{"id", worker}, {"name", name}, {"state", state}});
}

}  // namespace tessera::server
