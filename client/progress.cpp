#include "client/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/base/error.hpp"

namespace tessera::client {

namespace {
template <class Value>
void read(const Json& job, const char* key, Value& value) {
  const auto found = job.find(key);
  if (found == job.end() || found->is_null()) return;
  try {
    value = found->get<Value>();
  } catch (const Json::exception&) {
    throw Error(ErrorKind::failed, fmt::format("the server's job object has an odd \"{}\"", key));
  }
}

void read_seconds(const Json& job, const char* key, std::optional<double>& value) {
  double seconds = -1;
  read(job, key, seconds);
  if (seconds >= 0) value = seconds;
}
}  // namespace

JobState job_state_from(const Json& job) {
  if (!job.is_object() || !job.contains("id") || !job.contains("state") ||
      !job.contains("progress"))
    throw Error(ErrorKind::failed, "the server's answer is no job object");
  JobState out;
  read(job, "id", out.id);
  read(job, "name", out.name);
  read(job, "state", out.state);
  read(job, "progress", out.progress);
  read(job, "samples_per_second", out.samples_per_second);
  read_seconds(job, "eta_seconds", out.eta_seconds);
  read_seconds(job, "eta_low_seconds", out.eta_low_seconds);
  read_seconds(job, "eta_high_seconds", out.eta_high_seconds);
  read(job, "samples", out.samples);
  read(job, "samples_done", out.samples_done);
  read(job, "samples_total", out.samples_total);
  if (const auto frames = job.find("frames"); frames != job.end() && frames->is_object()) {
    read(*frames, "first", out.first_frame);
    read(*frames, "count", out.frames);
  }
  read(job, "frames_done", out.frames_done);
  read(job, "frames_shortened", out.frames_shortened);
  read(job, "render_seconds", out.render_seconds);
  read(job, "cpu_seconds", out.cpu_seconds);
  read(job, "rays", out.rays);
  read(job, "error", out.error);
  read(job, "waiting_for", out.waiting_for);
  return out;
}

JobState overall(std::span<const JobState> jobs) {
  JobState out;
  bool all_ended = true, all_done = true, rendering = false;
  for (const JobState& job : jobs) {
    all_ended = all_ended && job.ended();
    all_done = all_done && job.state == "done";
    rendering = rendering || job.state == "rendering";
    out.samples_done += job.samples_done;
    out.samples_total += job.samples_total;
    out.rays += job.rays;
    out.cpu_seconds += job.cpu_seconds;
    if (job.ended()) continue;
    out.samples_per_second += job.samples_per_second;
    if (out.waiting_for.empty()) out.waiting_for = job.waiting_for;
  }
  out.state = all_done                            ? "done"
              : all_ended                         ? "failed"
              : rendering || out.samples_done > 0 ? "rendering"
                                                  : "queued";
  if (out.samples_per_second > 0) out.waiting_for.clear();
  if (out.samples_total > 0)
    out.progress = static_cast<double>(out.samples_done) / static_cast<double>(out.samples_total);
  if (!all_ended && out.samples_per_second > 0)
    out.eta_seconds =
        static_cast<double>(out.samples_total - out.samples_done) / out.samples_per_second;
  return out;
}

std::string duration_text(double seconds) {
  const auto whole = static_cast<std::int64_t>(std::llround(std::clamp(seconds, 0.0, 1e9)));
  const std::int64_t s = whole % 60, m = whole / 60 % 60, h = whole / 3600 % 24, d = whole / 86400;
  if (d > 0) return fmt::format("{} d {:02}:{:02}", d, h, m);
  if (h > 0) return fmt::format("{}:{:02}:{:02}", h, m, s);
  return fmt::format("{}:{:02}", m, s);
}

std::string count_text(double count) {
  constexpr std::array<std::string_view, 5> units{"", " k", " M", " G", " T"};
  std::size_t unit = 0;
  while (count >= 999.5 && unit + 1 < units.size()) {
    count /= 1000;
    ++unit;
  }
  if (unit == 0) return fmt::format("{:.0f}", count);
  const int digits = count >= 99.95 ? 0 : count >= 9.995 ? 1 : 2;
  return fmt::format("{:.{}f}{}", count, digits, units[unit]);
}

std::string upload_text(std::uint64_t done, std::uint64_t total) {
  return fmt::format("uploading {}B of {}B", count_text(static_cast<double>(done)),
                     count_text(static_cast<double>(total)));
}

std::string sent_text(std::size_t files, std::uint64_t bytes, std::uint64_t scene_bytes) {
  const std::string scene = count_text(static_cast<double>(scene_bytes));
  if (bytes == 0) return fmt::format("nothing to send: the server has the scene's {}B", scene);
  return fmt::format("sent {}B in {} file{}, of a scene of {}B",
                     count_text(static_cast<double>(bytes)), files, files == 1 ? "" : "s", scene);
}

std::string eta_text(const JobState& job) {
  if (!job.eta_seconds) return {};
  std::string out = duration_text(*job.eta_seconds);
  if (!job.eta_low_seconds || !job.eta_high_seconds) return out;
  const std::string low = duration_text(*job.eta_low_seconds);
  const std::string high = duration_text(*job.eta_high_seconds);
  return low == high ? out : fmt::format("{} ({}-{})", out, low, high);
}

std::string progress_line(const JobState& job) {
  // Rounded down: 100 % is said when all is done, and not before.
  std::string out = fmt::format("{:<9} {:5.1f} %", job.state, std::floor(job.progress * 1000) / 10);
  if (job.frames > 1) out += fmt::format("  {} of {} frames", job.frames_done, job.frames);
  if (job.frames_shortened > 0) out += fmt::format(", {} by noise", job.frames_shortened);
  if (job.state == "rendering" && job.samples_per_second > 0)
    out += fmt::format("  {} samples/s", count_text(job.samples_per_second));
  if (job.eta_seconds && !job.ended()) out += fmt::format("  {} left", eta_text(job));
  if (!job.waiting_for.empty() && !job.ended()) out += "  waiting: " + job.waiting_for;
  if (job.state == "done") out += fmt::format("  in {}", duration_text(job.render_seconds));
  return out;
}

bool LineGate::due(const JobState& job, Instant now) {
  const int tenth = static_cast<int>(job.progress * 10);
  if (job.state == state_ && job.waiting_for == waiting_for_ && tenth == tenth_ &&
      now - last_ < std::chrono::seconds(30))
    return false;
  state_ = job.state;
  waiting_for_ = job.waiting_for;
  tenth_ = tenth;
  last_ = now;
  return true;
}

namespace {
void write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(descriptor, text.data(), text.size());
    if (written <= 0) return;  // whoever read it is gone; that is no reason to stop the work
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}
}  // namespace

ProgressPrinter::ProgressPrinter(int descriptor)
    : descriptor_(descriptor), terminal_(isatty(descriptor) == 1) {}

ProgressPrinter::~ProgressPrinter() { finish(); }

void ProgressPrinter::rewrite(std::string_view text) {
  write_all(descriptor_, fmt::format("\r{}\x1b[K", text));
  open_ = true;
}

void ProgressPrinter::show(const JobState& job, std::string_view prefix) {
  const std::string line = std::string(prefix) + progress_line(job);
  if (terminal_)
    rewrite(line);
  else if (gate_.due(job, std::chrono::steady_clock::now()))
    write_all(descriptor_, line + "\n");
}

void ProgressPrinter::remark(std::string_view text) {
  if (terminal_) rewrite(text);
}

void ProgressPrinter::remark_now_and_then(std::string_view text) {
  const Instant now = std::chrono::steady_clock::now();
  if (now - last_remark_ < std::chrono::milliseconds(100)) return;
  last_remark_ = now;
  remark(text);
}

void ProgressPrinter::say(std::string_view text) {
  write_all(descriptor_, fmt::format("{}{}\n", open_ ? "\r\x1b[K" : "", text));
  open_ = false;
}

void ProgressPrinter::finish() {
  if (open_) write_all(descriptor_, "\n");
  open_ = false;
}

}  // namespace tessera::client
