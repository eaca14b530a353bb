#include "client/progress.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <nlohmann/json.hpp>

#include "tests/unit/client/support.hpp"

namespace tessera::client {
namespace {

JobState rendering(double progress) {
  JobState job;
  job.id = 1;
  job.state = "rendering";
  job.progress = progress;
  return job;
}

TEST(Duration, is_rounded_to_seconds_and_shows_what_matters) {
  EXPECT_EQ(duration_text(0), "0:00");
  EXPECT_EQ(duration_text(41.6), "0:42");
  EXPECT_EQ(duration_text(59.7), "1:00");
  EXPECT_EQ(duration_text(725), "12:05");
  EXPECT_EQ(duration_text(3 * 3600 + 4 * 60 + 5), "3:04:05");
  EXPECT_EQ(duration_text(2 * 86400 + 3 * 3600 + 4 * 60), "2 d 03:04");
  EXPECT_EQ(duration_text(-5), "0:00");
  EXPECT_EQ(duration_text(1e300), duration_text(1e9));
}

TEST(Count, has_three_digits_and_a_power_of_a_thousand) {
  EXPECT_EQ(count_text(0), "0");
  EXPECT_EQ(count_text(812), "812");
  EXPECT_EQ(count_text(999.4), "999");
  EXPECT_EQ(count_text(999.6), "1.00 k");
  EXPECT_EQ(count_text(12'400), "12.4 k");
  EXPECT_EQ(count_text(3.25e6), "3.25 M");
  EXPECT_EQ(count_text(123.4e9), "123 G");
  EXPECT_EQ(count_text(5e15), "5000 T");
}

TEST(ProgressLine, has_state_share_rate_and_time_left) {
  JobState job = rendering(0.4239);
  job.samples_per_second = 12.4e6;
  job.eta_seconds = 83;
  EXPECT_EQ(progress_line(job), "rendering  42.3 %  12.4 M samples/s  1:23 left");
  job.eta_low_seconds = 70;
  job.eta_high_seconds = 110;
  EXPECT_EQ(progress_line(job), "rendering  42.3 %  12.4 M samples/s  1:23 (1:10-1:50) left");
  job.eta_low_seconds = 82.7;
  job.eta_high_seconds = 83.4;
  EXPECT_EQ(eta_text(job), "1:23") << "the interval says no more";
  job.eta_seconds.reset();
  job.samples_per_second = 0;
  EXPECT_EQ(progress_line(job), "rendering  42.3 %");
}

TEST(ProgressLine, says_what_is_waited_for) {
  const JobState job = job_state_from(Json{
      {"id", 1}, {"state", "queued"}, {"progress", 0}, {"waiting_for", "no worker is connected"}});
  EXPECT_EQ(progress_line(job), "queued      0.0 %  waiting: no worker is connected");
  LineGate gate;
  JobState before = job;
  before.waiting_for.clear();
  const Instant now{};
  EXPECT_TRUE(gate.due(before, now));
  EXPECT_TRUE(gate.due(job, now)) << "a change that is worth a line";
  EXPECT_FALSE(gate.due(job, now));
}

TEST(ProgressLine, says_how_many_frames_ended_by_their_noise) {
  const JobState job = job_state_from(Json{{"id", 1},
                                           {"state", "rendering"},
                                           {"progress", 0.5},
                                           {"frames", {{"first", 1}, {"count", 5}}},
                                           {"frames_done", 3},
                                           {"frames_shortened", 2}});
  EXPECT_EQ(progress_line(job), "rendering  50.0 %  3 of 5 frames, 2 by noise");
}

TEST(ProgressLine, says_a_hundred_per_cent_only_when_all_is_done) {
  EXPECT_EQ(progress_line(rendering(0.9999)), "rendering  99.9 %");
  JobState job = rendering(1);
  job.state = "done";
  job.eta_seconds = 0;
  job.render_seconds = 65;
  EXPECT_EQ(progress_line(job), "done      100.0 %  in 1:05");
}

TEST(LineGate, lets_through_the_first_changes_of_state_tenths_and_one_in_30_seconds) {
  LineGate gate;
  const Instant start{std::chrono::hours(5)};
  EXPECT_TRUE(gate.due(rendering(0), start));
  EXPECT_FALSE(gate.due(rendering(0.05), start + std::chrono::seconds(1)));
  EXPECT_TRUE(gate.due(rendering(0.1), start + std::chrono::seconds(2)));
  EXPECT_FALSE(gate.due(rendering(0.11), start + std::chrono::seconds(31)));
  EXPECT_TRUE(gate.due(rendering(0.12), start + std::chrono::seconds(32)));
  JobState paused = rendering(0.12);
  paused.state = "paused";
  EXPECT_TRUE(gate.due(paused, start + std::chrono::seconds(33)));
  EXPECT_FALSE(gate.due(paused, start + std::chrono::seconds(34)));
}

TEST(ProgressPrinter, writes_plain_lines_where_there_is_no_terminal) {
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe(ends.data()), 0);
  {
    ProgressPrinter printer(ends[1]);
    printer.remark("not shown");
    printer.show(rendering(0.01));
    printer.show(rendering(0.02));
    printer.show(rendering(0.5));
  }
  close(ends[1]);
  std::array<char, 512> text{};
  const ssize_t size = read(ends[0], text.data(), text.size());
  close(ends[0]);
  ASSERT_GT(size, 0);
  EXPECT_EQ(std::string(text.data(), static_cast<std::size_t>(size)),
            "rendering   1.0 %\nrendering  50.0 %\n");
}

TEST(JobState, is_read_from_the_servers_object_whatever_else_stands_in_it) {
  const Json job = {{"id", 7},
                    {"name", "n"},
                    {"state", "done"},
                    {"progress", 1.0},
                    {"eta_seconds", {}},
                    {"error", {}},
                    {"rays", 123456789012},
                    {"samples", 64},
                    {"news", {1, 2}},
                    {"render_seconds", 2.5},
                    {"frames", {{"first", 3}, {"last", 3}}}};
  const JobState state = job_state_from(job);
  EXPECT_EQ(state.id, 7U);
  EXPECT_TRUE(state.ended());
  EXPECT_FALSE(state.eta_seconds.has_value());
  EXPECT_EQ(state.error, "");
  EXPECT_EQ(state.rays, 123456789012);
  EXPECT_EQ(state.first_frame, 3);
  EXPECT_EQ(state.render_seconds, 2.5);
}

JobState counted(const char* state, std::int64_t done, std::int64_t total, double rate) {
  JobState out;
  out.state = state;
  out.samples_done = done;
  out.samples_total = total;
  out.samples_per_second = rate;
  return out;
}

TEST(Overall, several_jobs_are_shown_as_one) {
  const JobState all =
      overall(std::vector<JobState>{counted("done", 100, 100, 0), counted("rendering", 50, 300, 25),
                                    counted("queued", 0, 100, 0)});
  EXPECT_EQ(all.state, "rendering");
  EXPECT_DOUBLE_EQ(all.progress, 0.3);
  EXPECT_EQ(all.samples_per_second, 25);
  EXPECT_EQ(all.eta_seconds, 14);
  EXPECT_EQ(overall(std::vector<JobState>{counted("queued", 0, 9, 0)}).state, "queued");
}

TEST(Overall, it_has_ended_when_all_have_and_is_done_when_all_are) {
  const JobState done = counted("done", 4, 4, 0), lost = counted("cancelled", 1, 4, 0);
  EXPECT_EQ(overall(std::vector<JobState>{done, done}).state, "done");
  EXPECT_EQ(overall(std::vector<JobState>{done, lost}).state, "failed");
  EXPECT_FALSE(overall(std::vector<JobState>{done, counted("paused", 1, 4, 0)}).ended());
  EXPECT_FALSE(overall(std::vector<JobState>{done, lost}).eta_seconds.has_value());
}

TEST(Overall, what_is_waited_for_is_said_while_nothing_renders) {
  JobState waiting = counted("queued", 0, 4, 0);
  waiting.waiting_for = "a worker";
  EXPECT_EQ(overall(std::vector<JobState>{waiting}).waiting_for, "a worker");
  EXPECT_EQ(overall(std::vector<JobState>{waiting, counted("rendering", 1, 4, 9)}).waiting_for, "");
}

TEST(Upload, what_was_sent_is_said_and_that_nothing_was) {
  EXPECT_EQ(sent_text(2, 1'250'000, 3'000'000), "sent 1.25 MB in 2 files, of a scene of 3.00 MB");
  EXPECT_EQ(sent_text(1, 200, 300), "sent 200B in 1 file, of a scene of 300B");
  EXPECT_EQ(sent_text(0, 0, 3'000'000), "nothing to send: the server has the scene's 3.00 MB");
}

TEST(JobState, which_is_none_or_odd_is_a_failure_of_the_server) {
  for (const char* text : {"[]", "{}", R"({"id": 1, "state": "done"})",
                           R"({"id": "x", "state": "done", "progress": 1})"}) {
    const Error error = error_of([&] { (void)job_state_from(Json::parse(text)); });
    EXPECT_EQ(error.kind(), ErrorKind::failed) << text;
  }
}

}  // namespace
}  // namespace tessera::client
