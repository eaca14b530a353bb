#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "common/base/clock.hpp"
#include "common/base/json.hpp"
#include "common/job/task.hpp"

/// What a person is told while a job renders. Pure, but for ProgressPrinter.
namespace tessera::client {

/// What the client reads of the server's job object.
struct JobState {
  JobId id = 0;
  std::string name;
  std::string state;  ///< queued, rendering, paused, done, failed, cancelled
  double progress = 0;
  double samples_per_second = 0;
  std::optional<double> eta_seconds;
  std::optional<double> eta_low_seconds, eta_high_seconds;  ///< 80 % interval
  std::int64_t samples = 0;                                 ///< of each pixel
  std::int64_t samples_done = 0;                            ///< of all pixels together
  std::int64_t samples_total = 0;                           ///< of all pixels together
  std::int64_t first_frame = 1;
  std::int64_t frames = 1;
  std::int64_t frames_done = 0;
  std::int64_t frames_shortened = 0;  ///< of several, ended by their noise before all samples
  double render_seconds = 0;
  double cpu_seconds = 0;
  std::int64_t rays = 0;
  std::string error;
  std::string waiting_for;  ///< why it has work and no worker does any of it

  [[nodiscard]] bool ended() const {
    return state == "done" || state == "failed" || state == "cancelled";
  }
};
/// Throws Error{failed} if it lacks id, state or progress. What else is lacking keeps its default,
/// and what is unknown is passed over: a newer server may say more.
JobState job_state_from(const Json& job);

/// Several jobs as if they were one: samples and rates are sums, and the whole has ended when all
/// have.
JobState overall(std::span<const JobState> jobs);

/// "0:42", "12:05", "3:04:05", "2 d 03:04": a duration, rounded to whole seconds.
std::string duration_text(double seconds);
/// "812", "12.4 k", "3.25 M", "1.07 G": three digits and a power of a thousand.
std::string count_text(double count);
/// "uploading 1.25 MB of 3.00 MB".
std::string upload_text(std::uint64_t done, std::uint64_t total);
/// "sent 1.25 MB in 2 files, of a scene of 3.00 MB"; "nothing to send: the server has the
/// scene's 3.00 MB".
std::string sent_text(std::size_t files, std::uint64_t bytes, std::uint64_t scene_bytes);
/// "1:23", or with the interval where it is known and says more: "1:23 (1:10-1:50)".
std::string eta_text(const JobState& job);
/// "rendering  42.3 %  12.4 M samples/s  1:23 (1:10-1:50) left".
std::string progress_line(const JobState& job);

/// Which states are worth a line where no line can be rewritten: the first, a change of state
/// or of what is waited for, every tenth of the work, and else one in 30 seconds.
class LineGate {
 public:
  bool due(const JobState& job, Instant now);

 private:
  std::string state_, waiting_for_;
  int tenth_ = -1;
  Instant last_{};
};

/// Shows progress on a stream: on a terminal one line that is rewritten, else a line now and then.
class ProgressPrinter {
 public:
  /// `descriptor`: 1 for standard output, 2 for standard error.
  explicit ProgressPrinter(int descriptor);
  ~ProgressPrinter();
  ProgressPrinter(const ProgressPrinter&) = delete;
  ProgressPrinter& operator=(const ProgressPrinter&) = delete;

  /// `prefix` stands before the line.
  void show(const JobState& job, std::string_view prefix = {});
  /// A remark in the line's place, on a terminal alone.
  void remark(std::string_view text);
  /// The same, ten times a second at most: for what is told after every piece of something.
  void remark_now_and_then(std::string_view text);
  /// A line that stays.
  void say(std::string_view text);
  /// Ends the line, so that what is printed next begins a new one.
  void finish();

 private:
  void rewrite(std::string_view text);
  int descriptor_;
  bool terminal_;
  bool open_ = false;
  Instant last_remark_{};
  LineGate gate_;
};

}  // namespace tessera::client
