#include "server/http/metrics.hpp"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>

#include "common/base/build_info.hpp"

namespace tessera::server {

namespace {

class Writer {
 public:
  /// `type` is "gauge" or "counter".
  void family(std::string_view name, std::string_view type, std::string_view help) {
    name_ = name;
    text_ += fmt::format("# HELP tessera_{0} {1}\n# TYPE tessera_{0} {2}\n", name, help, type);
  }
  template <class Number>
  void sample(Number value, std::string_view labels = {}) {
    text_ += labels.empty() ? fmt::format("tessera_{} {}\n", name_, value)
                            : fmt::format("tessera_{}{{{}}} {}\n", name_, labels, value);
  }
  template <class Number>
  void single(std::string_view name, std::string_view type, std::string_view help, Number value) {
    family(name, type, help);
    sample(value);
  }
  std::string take() { return std::move(text_); }

 private:
  std::string_view name_;
  std::string text_;
};

template <class Items, class State>
void by_state(Writer& out, const Items& items, std::initializer_list<std::string_view> states,
              State state_of) {
  for (const std::string_view state : states) {
    const auto count = std::count_if(items.begin(), items.end(),
                                     [&](const auto& item) { return state_of(item) == state; });
    out.sample(count, fmt::format("state=\"{}\"", state));
  }
}

void write_jobs(Writer& out, const std::vector<JobStatus>& jobs) {
  out.family("jobs", "gauge", "Jobs by state.");
  by_state(out, jobs, {"queued", "rendering", "paused", "done", "failed", "cancelled"},
           [](const JobStatus& job) -> std::string_view { return job.view.state; });
  std::int64_t tasks = 0, done = 0, leased = 0, samples = 0, rays = 0, rejected = 0;
  for (const JobStatus& job : jobs) {
    tasks += job.view.tasks;
    done += job.view.tasks_done;
    leased += job.view.leased;
    samples += job.view.samples_done;
    rays += job.rays;
    rejected += job.rejected_samples;
  }
  out.single("tasks", "gauge", "Tasks of all jobs that are kept.", tasks);
  out.single("tasks_done", "gauge", "Of those, tasks whose result was accepted.", done);
  out.single("tasks_leased", "gauge", "Of those, tasks that workers hold at present.", leased);
  out.single("samples_done", "gauge", "Samples (pixels times samples) of all jobs that are kept.",
             samples);
  out.single("rays", "gauge", "Rays traced for all jobs that are kept.", rays);
  out.single("rejected_samples", "gauge", "Samples that were NaN or Inf and count as black.",
             rejected);
}

void write_workers(Writer& out, const std::vector<WorkerView>& workers) {
  out.family("workers", "gauge", "Workers that are connected, by state.");
  by_state(out, workers, {"idle", "preparing", "rendering", "stalled", "draining", "quarantined"},
           [](const WorkerView& worker) -> std::string_view { return worker.state; });
  std::int64_t threads = 0;
  double speed = 0;
  for (const WorkerView& worker : workers) {
    threads += worker.info.threads;
    speed += worker.samples_per_second;
  }
  out.single("worker_threads", "gauge", "Threads of all workers that are connected.", threads);
  out.single("samples_per_second", "gauge", "Measured speed of all workers together.", speed);
}

void write_counters(Writer& out, const CoordinatorCounters& counters) {
  out.family(
      "results_total", "counter",
      "Results that workers sent, by what became of them; duplicate: not needed by a job that is "
      "under way, stale: of a job that has ended.");
  const CoordinatorCounters::Rejected& rejected = counters.rejected;
  out.sample(counters.results_accepted, "outcome=\"accepted\"");
  out.sample(counters.results_duplicate, "outcome=\"duplicate\"");
  out.sample(counters.results_stale, "outcome=\"stale\"");
  out.sample(rejected.plan + rejected.task + rejected.lease + rejected.statistics + rejected.tile,
             "outcome=\"rejected\"");
  out.family("results_rejected_total", "counter", "Results that were rejected, by reason.");
  out.sample(rejected.plan, "reason=\"plan\"");
  out.sample(rejected.task, "reason=\"task\"");
  out.sample(rejected.lease, "reason=\"lease\"");
  out.sample(rejected.statistics, "reason=\"statistics\"");
  out.sample(rejected.tile, "reason=\"tile\"");
  out.single("leases_granted_total", "counter", "Leases given to workers.",
             counters.leases_granted);
  out.single("leases_revoked_total", "counter",
             "Leases taken back from workers that are connected, expired ones among them.",
             counters.leases_revoked);
  out.single("leases_expired_total", "counter",
             "Leases whose worker made no progress for too long.", counters.leases_expired);
  out.single("store_errors_total", "counter",
             "Times that the disk refused results; they are tried again.", counters.store_errors);
  out.single("workers_joined_total", "counter", "Workers that connected and were welcomed.",
             counters.workers_joined);
  out.single("worker_cache_bytes", "gauge",
             "Bytes that the caches of all connected workers hold; a folder that several share "
             "counts for each.",
             counters.worker_cache_bytes);
  out.single("worker_cache_limit_bytes", "gauge", "The most that they may hold.",
             counters.worker_cache_most);
  out.single("worker_cache_evictions_total", "counter",
             "Files that workers forgot, those used longest ago first.",
             counters.worker_cache_evictions);
  out.single("workers_lost_total", "counter", "Workers whose connection ended without a word.",
             counters.workers_lost);
}

void write_storage(Writer& out, const StorageUse& storage) {
  out.family("storage_bytes", "gauge", "Bytes in the data folder, by what they are.");
  out.sample(storage.journal, "kind=\"journal\"");
  out.sample(storage.checkpoints, "kind=\"checkpoints\"");
  out.sample(storage.blobs, "kind=\"blobs\"");
  out.sample(storage.pictures, "kind=\"pictures\"");
  out.single("storage_limit_bytes", "gauge",
             "Beyond so many of these nothing new is taken; 0: no limit.", storage.disk_most);
  out.single("storage_free_bytes", "gauge", "Bytes free on the data folder's file system.",
             storage.disk_free);
  out.single("blob_cache_bytes", "gauge",
             "Of the blobs, those that no job needs, and uploads that broke off.",
             storage.blob_cache);
  out.single("blob_cache_limit_bytes", "gauge",
             "Beyond so many of them the least recently used go.", storage.blob_cache_most);
  out.single("blob_cache_evictions_total", "counter", "Blobs of them that were removed.",
             storage.blobs_evicted);
  out.single("blob_cache_evicted_bytes_total", "counter", "Their bytes.",
             storage.blob_bytes_evicted);
  out.single("film_memory_bytes", "gauge", "Memory of the films of unfinished frames.",
             storage.films);
  out.single("film_memory_limit_bytes", "gauge", "The most that they may take.",
             storage.films_most);
}

}  // namespace

ProcessUsage process_usage() {
  ProcessUsage out;
  rusage usage{};
  if (getrusage(RUSAGE_SELF, &usage) == 0) {
    const auto time = [](const timeval& value) {
      return static_cast<double>(value.tv_sec) + static_cast<double>(value.tv_usec) * 1e-6;
    };
    out.cpu_seconds = time(usage.ru_utime) + time(usage.ru_stime);
    out.peak_resident_bytes = static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
  }
  std::uint64_t total_pages = 0, resident_pages = 0;
  std::ifstream statm("/proc/self/statm");
  if (statm >> total_pages >> resident_pages)
    out.resident_bytes = resident_pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  std::error_code error;
  for (std::filesystem::directory_iterator entry("/proc/self/fd", error), end;
       !error && entry != end; entry.increment(error))
    ++out.open_files;
  return out;
}

std::string metrics_text(const std::vector<JobStatus>& jobs, const std::vector<WorkerView>& workers,
                         const CoordinatorCounters& coordinator, const StorageUse& storage,
                         const HttpCounters& http, const ProcessUsage& process) {
  Writer out;
  out.family("build_info", "gauge", "The release and commit; always 1.");
  out.sample(1, fmt::format("version=\"{}\",commit=\"{}\"", version(), build_commit()));
  write_jobs(out, jobs);
  write_workers(out, workers);
  write_counters(out, coordinator);
  write_storage(out, storage);
  out.single("http_requests_total", "counter", "HTTP requests since the start.", http.requests);
  out.single("http_connections_total", "counter", "HTTP connections accepted since the start.",
             http.connections_accepted);
  out.single("http_connections_refused_total", "counter",
             "HTTP connections refused because there were too many.", http.connections_refused);
  out.single("http_connections", "gauge", "HTTP connections open at present.",
             http.connections_open);
  out.single("blob_bytes_received_total", "counter", "Bytes of uploads that came, blobs and parts.",
             http.blob_bytes_received);
  out.single("process_cpu_seconds_total", "counter", "CPU time of this process, user and system.",
             process.cpu_seconds);
  out.single("process_resident_bytes", "gauge", "Memory of this process that is resident.",
             process.resident_bytes);
  out.single("process_peak_resident_bytes", "gauge", "The most that it ever was.",
             process.peak_resident_bytes);
  out.single("process_open_files", "gauge", "File descriptors that are open.", process.open_files);
  return out.take();
}

}  // namespace tessera::server
