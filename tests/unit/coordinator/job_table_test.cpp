#include "server/coordinator/job_table.hpp"

#include <gmock/gmock.h>
#include <stdlib.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "common/base/error.hpp"
#include "common/base/files.hpp"
#include "common/base/limits.hpp"
#include "server/coordinator/frame_file.hpp"
#include "tests/unit/session/synthetic.hpp"

namespace tessera::server {
namespace {

using std::chrono::seconds;

JobRecord record() {
  JobRecord record;
  record.id = 3;
  record.spec.name = "table";
  record.spec.render.width = 40;
  record.spec.render.height = 30;
  record.spec.render.samples = 10;
  record.spec.tile = 16;
  record.priority = 5;
  return record;
}

Instant at(int second) { return Instant(seconds(1000 + second)); }

TEST(Job, IsDoneOnlyOnceItsFilesAreWritten) {
  Job job(record(), at(0), 0);
  JobView view;
  view.id = 3;
  view.state = "done";
  view.samples = view.samples_done = 12000;
  EXPECT_EQ(job.status(view, at(1)).view.state, "rendering");
  job.record.state = "done";
  job.ended = true;
  EXPECT_EQ(job.status(view, at(1)).view.state, "done");
  EXPECT_EQ(job.status(std::nullopt, at(1)).progress, 1);
}

TEST(Job, AwaitsLooksAtItsNoiseUnderTheirPlanUntilItEndsOrHasNoThreshold) {
  JobRecord watched = record();
  watched.spec.noise_threshold = 0.1;
  const Job job(watched, at(0), 0);
  const Digest plan = job.plan->digest;
  EXPECT_TRUE(job.awaits_noise(plan));
  EXPECT_FALSE(job.awaits_noise(digest_of("another plan")));
  for (bool Job::*const end : {&Job::ended, &Job::broken}) {
    Job over = job;
    over.*end = true;
    EXPECT_FALSE(over.awaits_noise(plan));
  }
  Job ending = job;
  ending.ending = true;
  EXPECT_TRUE(ending.awaits_noise(plan)) << "the disk may refuse it";
  watched.spec.noise_threshold = 0;
  const Job extended(watched, at(0), 0);
  EXPECT_EQ(extended.plan->digest, plan);
  EXPECT_FALSE(extended.awaits_noise(plan));
}

TEST(Job, KnowsThePlanThatItHadBeforeItsTimeWasUpAndCallsItEarlierUntilItIsThePlanAgain) {
  JobRecord asked = record();
  asked.spec.render.samples = 1000;
  const Digest before = Job(asked, at(0), 0).plan->digest;
  JobRecord shortened = record();
  shortened.shortened_from = 1000;
  const Job job(shortened, at(0), 0);
  EXPECT_NE(job.plan->digest, before);
  EXPECT_EQ(job.earlier_plans, std::vector<Digest>{before});
  EXPECT_EQ(job.status(std::nullopt, at(0)).shortened_from, 1000);
  shortened.extended_from = {10};
  shortened.spec.render.samples = 1000;
  const Job extended(shortened, at(0), 0);
  EXPECT_EQ(extended.plan->digest, before);
  EXPECT_EQ(extended.earlier_plans, std::vector<Digest>{job.plan->digest});
}

TEST(Job, CountsOfEachFrameWhatItHas) {
  JobRecord three = record();
  three.spec.render.samples = 100;  // ends 1, 4, 16, 64, 100
  three.spec.frames = FrameRange{1, 3, 1};
  three.shortened_frames = {{1, 16}, {3, 64}};
  Job job(three, at(0), 0);
  EXPECT_EQ(job.samples_of(1), 16);
  EXPECT_EQ(job.passes_of(1), 3U);
  EXPECT_EQ(job.samples_of(2), 100);
  EXPECT_EQ(job.passes_of(2), 5U);
  EXPECT_EQ(job.samples_total(), 40 * 30 * (16 + 100 + 64));
  EXPECT_EQ(job.tasks_total(), 6 * (3 + 5 + 4));
  EXPECT_EQ(samples_of_frames(job).fewest, 16);
  EXPECT_EQ(samples_of_frames(job).most, 100);
  const JobStatus status = job.status(std::nullopt, at(1));
  EXPECT_EQ(status.frames_shortened, 2U);
  EXPECT_EQ(status.view.samples, job.samples_total());
  EXPECT_EQ(status.view.tasks, job.tasks_total());
  job.record.shortened_frames[2] = 16;
  EXPECT_EQ(samples_of_frames(job).most, 64) << "no frame has all that was asked for";
  const JobRecord end = job.end_record("done", "", at(2), 2);
  job.record.shortened_frames.erase(2);
  job.has_ended_as(end);
  EXPECT_EQ(job.record.state, "done");
  EXPECT_EQ(job.record.shortened_frames.size(), 2U) << "what was said meanwhile stands";
}

TEST(Job, ThatIsExtendedToTheSamplesThatWereAskedForHasItsPlanAgain) {
  JobRecord extended = record();
  extended.extended_from = {10};
  const Job again(extended, at(0), 0);
  EXPECT_TRUE(again.earlier_plans.empty()) << "results of it are its own";
  EXPECT_GT(again.version_base, 0U);
  extended.spec.render.samples = 11;
  EXPECT_EQ(Job(extended, at(0), 0).earlier_plans, std::vector<Digest>{again.plan->digest});
}

TEST(Job, RenderTimeRunsFromTheFirstLeaseToTheLastFold) {
  Job job(record(), at(0), 0);
  EXPECT_EQ(job.render_seconds(at(9), false), 0);
  job.first_lease = at(10);
  EXPECT_EQ(job.render_seconds(at(15), false), 0) << "nothing came of its leases";
  job.last_fold = at(12);
  EXPECT_EQ(job.render_seconds(at(15), true), 5);
  job.ending = true;
  EXPECT_EQ(job.render_seconds(at(15), true), 2);
  EXPECT_EQ(job.end_record("done", "", at(15), 77).render_seconds, 2);
  EXPECT_EQ(job.end_record("done", "", at(15), 77).finished, 77);
}

TEST(Job, RenderTimeStandsStillWhileNothingIsLeased) {
  Job job(record(), at(0), 0);
  job.first_lease = at(10);
  job.last_fold = at(12);
  JobView view;
  view.state = "paused";
  EXPECT_EQ(job.status(view, at(100)).render_seconds, 2);
  EXPECT_EQ(job.status(view, at(200)).render_seconds, 2);
  view.leased = 1;
  EXPECT_EQ(job.status(view, at(200)).render_seconds, 190);
}

TEST(Job, WhatWasCountedBeforeARestartIsCountedFromItsResultsAlone) {
  JobRecord paused = record();
  paused.state = "paused";
  paused.rays = 1000;
  paused.rejected_samples = 7;
  paused.cpu_seconds = 2.5;
  paused.shares = {{"a", 10}};
  Job job(paused, at(0), 0);
  job.count("a", 10, 1000, 7, 2.5, Digest());
  const JobStatus status = job.status(std::nullopt, at(1));
  EXPECT_EQ(status.rays, 1000);
  EXPECT_EQ(status.rejected_samples, 7);
  EXPECT_EQ(status.cpu_seconds, 2.5);
  ASSERT_EQ(status.shares.size(), 1U);
  EXPECT_EQ(status.shares[0].samples, 10);
}

TEST(Job, RenderTimeGoesOnOverARestart) {
  JobRecord started = record();
  started.started = 100'000;
  const Job job(started, at(50), 130'000);
  EXPECT_EQ(job.render_seconds(at(51), true), 31);
  EXPECT_EQ(job.render_seconds(at(51), false), 30) << "and stands still until something is leased";
}

TEST(Job, SharesAreCountedByWorkerMostFirst) {
  Job job(record(), at(0), 0);
  Digest build;
  build.bytes[0] = 9;
  job.count("b", 10, 100, 1, 0.5, build);
  job.count("a", 10, 50, 0, 0.25, Digest());
  job.count("c", 30, 7, 2, 2, build);
  const JobStatus status = job.status(std::nullopt, at(1));
  ASSERT_EQ(status.shares.size(), 3U);
  EXPECT_EQ(status.shares[0].worker, "c");
  EXPECT_EQ(status.shares[1].worker, "a");
  EXPECT_EQ(status.rays, 157);
  EXPECT_EQ(status.rejected_samples, 3);
  EXPECT_EQ(status.cpu_seconds, 2.75);
  EXPECT_EQ(status.view.build, build) << "of the first result";
  // What the store keeps gives the same shares back.
  const Job again(job.end_record("cancelled", "", at(2), 1), at(3), 2);
  EXPECT_EQ(again.status(std::nullopt, at(3)).shares[0].samples, 30);
  EXPECT_EQ(again.status(std::nullopt, at(3)).view.state, "cancelled");
}

TEST(Job, PriorityOfTheRecordCountsAndNotThatOfTheSpec) {
  const Job job(record(), at(0), 0);
  EXPECT_EQ(job.plan->spec.priority, 5);
  EXPECT_EQ(job.plan->digest, JobPlan(record().spec).digest);
}

TEST(JobEvent, IsOneJsonObjectWhateverTheTexts) {
  Job job(record(), at(0), 0);
  job.record.error = "bad \xff byte and \"quotes\"";
  const auto json = nlohmann::json::parse(job_event(job.status(std::nullopt, at(0))));
  EXPECT_EQ(json["id"], 3);
  EXPECT_EQ(json["state"], "queued");
  EXPECT_THAT(json["error"].get<std::string>(), testing::HasSubstr("quotes"));
}

class Files : public testing::Test {
 protected:
  Files() {
    std::string name = (std::filesystem::temp_directory_path() / "tessera-files-XXXXXX").string();
    data = ::mkdtemp(name.data());
  }
  ~Files() override { std::filesystem::remove_all(data); }
  static std::vector<std::byte> bytes(std::size_t count, char value) {
    return {count, std::byte(value)};
  }
  static WriteContent content(std::size_t count, char value) {
    return [=](image::ByteSink& out) { out.append(bytes(count, value)); };
  }
  std::filesystem::path data;
};

TEST_F(Files, AreWholeUnderTheirNameOrNotThere) {
  const auto file = frame_path(data, 12, 7);
  EXPECT_EQ(file, data / "jobs" / "12" / "frame-0007.exr");
  write_whole(file, true, content(10, 'a'));
  write_whole(file, false, content(5, 'b'));
  EXPECT_EQ(read_file(file, 100), bytes(5, 'b'));
  // The temporary name cannot be taken.
  std::filesystem::create_directories(file.string() + ".part/full");
  EXPECT_THROW(write_whole(file, false, content(3, 'c')), Error);
  EXPECT_EQ(read_file(file, 100), bytes(5, 'b'));
}

TEST_F(Files, AreFoundAgainAfterAStartAndLeftoversAreRemoved) {
  for (const int frame : {-3, 1, 12345})
    write_whole(frame_path(data, 2, frame), false, content(1, 'x'));
  const auto leftover = job_folder(data, 2) / "frame-0009.exr.part";
  std::ofstream(leftover) << "half";
  EXPECT_THAT(frames_on_disk(data, 2), testing::ElementsAre(-3, 1, 12345));
  EXPECT_FALSE(std::filesystem::exists(leftover));
  EXPECT_TRUE(frames_on_disk(data, 3).empty());
}

TEST_F(Files, PictureOfAFileIsThatOfItsFilm) {
  const JobPlan plan(record().spec);
  const FilmSnapshot film = straight_fold(plan, 1);
  const auto file = frame_path(data, 3, 1);
  write_frame_exr(file, false, film, image::Metadata());
  EXPECT_EQ(read_file(file, limits::MiB), encode_frame_exr(film, image::Metadata()));
  EXPECT_EQ(png_of_file(file, 0.5), encode_frame_png(film, 0.5));
  EXPECT_EQ(resolve_rgba(film_of_file(file, plan.grid, 9)), resolve_rgba(film));
  EXPECT_EQ(film_of_file(file, plan.grid, 9).version, 9U);
}

}  // namespace
}  // namespace tessera::server
