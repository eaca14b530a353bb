#include <gmock/gmock.h>
#include <unistd.h>

#include <atomic>
#include <thread>

#include "common/base/limits.hpp"
#include "server/store/database.hpp"
#include "tests/unit/store/store_fixture.hpp"

namespace tessera::server {
namespace {

using ::testing::HasSubstr;

TEST_F(StoreTest, CountsItsOpensAndKeepsItsKey) {
  std::array<std::uint8_t, 16> key{};
  {
    const auto store = open({});
    EXPECT_EQ(store->epoch(), 1);
    key = store->grant_key();
    EXPECT_NE(key, (std::array<std::uint8_t, 16>{}));
  }
  const auto store = open({});
  EXPECT_EQ(store->epoch(), 2);
  EXPECT_EQ(store->grant_key(), key);
}

TEST_F(StoreTest, KeepsJobsWithAllTheirFields) {
  JobRecord record = job_record();
  record.idempotency_key = "key";
  record.idempotency_fingerprint = "print";
  {
    const auto store = open();
    EXPECT_EQ(store->put_job(record), 1);
    EXPECT_EQ(store->put_job(record), 2);
    record.id = 2;
    record.state = "failed";
    record.priority = -5;
    record.started = 5;
    record.finished = 6;
    record.error = "the scene has no camera \"main\"\n";
    record.render_seconds = 1.5;
    record.cpu_seconds = 2.75;
    record.rays = 1'000'000'000'000;
    record.rejected_samples = 3;
    record.shares = {{"näme with \"quotes\"", 10}, {"b", 4}};
    store->update_job(record);
  }
  const auto jobs = open()->list_jobs();
  ASSERT_EQ(jobs.size(), 2);
  EXPECT_EQ(jobs[0].state, "queued");
  EXPECT_EQ(jobs[1].id, 2);
  EXPECT_EQ(jobs[1].spec, record.spec);
  EXPECT_EQ(jobs[1].state, record.state);
  EXPECT_EQ(jobs[1].priority, -5);
  EXPECT_EQ(jobs[1].created, record.created);
  EXPECT_EQ(jobs[1].started, 5);
  EXPECT_EQ(jobs[1].finished, 6);
  EXPECT_EQ(jobs[1].error, record.error);
  EXPECT_EQ(jobs[1].render_seconds, 1.5);
  EXPECT_EQ(jobs[1].cpu_seconds, 2.75);
  EXPECT_EQ(jobs[1].rays, record.rays);
  EXPECT_EQ(jobs[1].rejected_samples, 3);
  EXPECT_EQ(jobs[1].shares, record.shares);
  EXPECT_EQ(jobs[1].idempotency_key, "key");
  EXPECT_EQ(jobs[1].idempotency_fingerprint, "print");
}

TEST_F(StoreTest, KeepsTheNewestFailuresOfEachJobAndCountsAll) {
  FailureRecord failure;
  failure.task = TaskId{-3, 7, 2};
  failure.lease = {4, UINT64_C(1) << 63U};
  failure.worker = 9;
  failure.worker_name = "render-\"1\"";
  failure.outcome = "failed";
  failure.started = 1'700'000'000'000;
  failure.ended = 1'700'000'000'500;
  failure.reason = "no memory";
  failure.log = "one\ntwo\n";
  FailureRecord preparation;
  preparation.outcome = "lost";
  {
    const auto store = open();
    store->add_failures(1, std::vector<FailureRecord>{failure, preparation});
    store->add_failures(2, std::vector<FailureRecord>(Store::failures_kept + 5, failure));
  }
  const auto store = open();
  const auto of_one = store->failures(1);
  ASSERT_EQ(of_one.size(), 2U);
  failure.number = 1;
  preparation.number = 2;
  EXPECT_EQ(of_one[0], preparation);
  EXPECT_EQ(of_one[1], failure);
  const auto of_two = store->failures(2);
  ASSERT_EQ(of_two.size(), Store::failures_kept);
  EXPECT_EQ(of_two.front().number, Store::failures_kept + 5);
  const std::map<JobId, std::uint64_t> counts{{1, 2}, {2, Store::failures_kept + 5}};
  EXPECT_EQ(store->failure_counts(), counts);
  EXPECT_TRUE(store->failures(3).empty());
}

TEST_F(StoreTest, KeepsQuarantinesByNameUntilTheyAreRemoved) {
  const Quarantine one{"render-1", "its fan is broken", "user", 1'700'000'000'001};
  const Quarantine two{"render-2", "it failed on 2 jobs", "server", 1'700'000'000'002};
  const Quarantine other{"render-1", "its disk is full", "user", 1'700'000'000'003};
  {
    const auto store = open();
    for (const Quarantine& quarantine : {two, one, other}) store->put_quarantine(quarantine);
    EXPECT_EQ(store->quarantines(), (std::vector<Quarantine>{other, two}));
  }
  const auto store = open();
  EXPECT_EQ(store->quarantines(), (std::vector<Quarantine>{other, two}));
  store->remove_quarantine("render-1");
  store->remove_quarantine("nobody");
  EXPECT_EQ(store->quarantines(), std::vector<Quarantine>{two});
}

TEST_F(StoreTest, DatabaseOfTheVersionBeforeIsBroughtToThisOneWithAllThatIsInIt) {
  JobId job = 0;
  {
    const auto store = open();
    JobRecord record = job_record();
    job = record.id = store->put_job(record);
    record.shortened_from = 512;
    store->update_job(record);
    append(*store, job, {1, 0, 0});
    store->put_quarantine({"render-1", "", "user", 1});
  }
  Database(folder_ / "tessera.db", Database::Mode::read_write)
      .execute("DROP TABLE shortened_frames; PRAGMA user_version = 5");
  const auto store = open();
  ASSERT_EQ(store->list_jobs().size(), 1U);
  EXPECT_EQ(store->list_jobs().front().spec.name, "cornell");
  EXPECT_EQ(store->list_jobs().front().shortened_from, 512);
  EXPECT_TRUE(store->list_jobs().front().shortened_frames.empty());
  EXPECT_EQ(store->quarantines().size(), 1U);
  expect_readable(*store, job, 1);
  store->shorten_frame(job, 1, 16);
  const std::map<std::int32_t, std::int64_t> shortened{{1, 16}};
  EXPECT_EQ(store->list_jobs().front().shortened_frames, shortened);
}

TEST_F(StoreTest, DatabaseOfTwoVersionsBeforeIsBroughtToThisOne) {
  JobId job = 0;
  {
    const auto store = open();
    job = store->put_job(job_record());
    append(*store, job, {1, 0, 0});
  }
  Database(folder_ / "tessera.db", Database::Mode::read_write)
      .execute(
          "DROP TABLE shortened_frames; DROP TABLE quarantines; ALTER TABLE jobs DROP COLUMN "
          "shortened_from; PRAGMA user_version = 4");
  const auto store = open();
  ASSERT_EQ(store->list_jobs().size(), 1U);
  JobRecord record = store->list_jobs().front();
  EXPECT_EQ(record.spec.name, "cornell");
  EXPECT_EQ(record.shortened_from, 0);
  expect_readable(*store, job, 1);
  record.shortened_from = 4096;
  store->update_job(record);
  EXPECT_EQ(store->list_jobs().front().shortened_from, 4096);
  store->put_quarantine({"render-1", "", "user", 1});
  EXPECT_EQ(store->quarantines().size(), 1U);
}

TEST_F(StoreTest, KeepsFramesThatEndedEarlyUntilTheirJobIsExtendedOrForgotten) {
  using Frames = std::map<std::int32_t, std::int64_t>;
  JobRecord first = job_record(), second = job_record();
  {
    const auto store = open();
    first.id = store->put_job(first);
    second.id = store->put_job(second);
    store->shorten_frame(first.id, 7, 64);
    store->shorten_frame(first.id, -3, 16);
    store->shorten_frame(second.id, 7, 256);
    store->shorten_frame(first.id, 7, 48);
    store->update_job(first);
    EXPECT_EQ(error_of([&] { store->shorten_frame(99, 1, 16); }).kind(), ErrorKind::not_found);
  }
  const auto store = open();
  EXPECT_EQ(store->list_jobs()[0].shortened_frames, (Frames{{-3, 16}, {7, 48}}))
      << "a job that is kept anew keeps them";
  EXPECT_EQ(store->list_jobs()[1].shortened_frames, (Frames{{7, 256}}));
  store->unshorten_frame(first.id, 7);
  EXPECT_EQ(store->list_jobs()[0].shortened_frames, (Frames{{-3, 16}}));
  EXPECT_EQ(store->list_jobs()[1].shortened_frames.size(), 1U) << "it is another job's";
  store->unshorten_frame(first.id, 7);
  store->extend_job(first, 3);
  EXPECT_TRUE(store->list_jobs()[0].shortened_frames.empty());
  EXPECT_EQ(store->list_jobs()[1].shortened_frames.size(), 1U);
  store->forget_job(second.id);
  EXPECT_EQ(Database(folder_ / "tessera.db", Database::Mode::read_only)
                .integer("SELECT count(*) FROM shortened_frames"),
            0);
}

TEST_F(StoreTest, ForgottenJobTakesItsFailuresAlong) {
  const auto store = open();
  const JobId gone = store->put_job(job_record()), stays = store->put_job(job_record());
  FailureRecord failure;
  failure.outcome = "lost";
  for (const JobId job : {gone, stays}) store->add_failures(job, {&failure, 1});
  store->forget_job(gone);
  EXPECT_TRUE(store->failures(gone).empty());
  EXPECT_EQ(store->failures(stays).size(), 1U);
  EXPECT_EQ(store->failure_counts().size(), 1U);
}

TEST_F(StoreTest, SkippedNumbersAreGivenToNoJob) {
  {
    const auto store = open();
    store->skip_jobs(7);
    EXPECT_EQ(store->put_job(job_record()), 8);
    store->skip_jobs(3);
    EXPECT_EQ(store->put_job(job_record()), 9);
    store->skip_jobs(20);
  }
  EXPECT_EQ(open()->put_job(job_record()), 21);
}

TEST_F(StoreTest, UpdatingAnUnknownJobIsAnError) {
  const auto store = open();
  JobRecord record = job_record();
  record.id = 9;
  EXPECT_EQ(error_of([&] { store->update_job(record); }).kind(), ErrorKind::not_found);
}

TEST_F(StoreTest, ResultsComeBackInTaskOrderAfterAReopen) {
  JobId job = 0;
  {
    const auto store = open();
    job = store->put_job(job_record());
    append(*store, job, {2, 0, 0});
    append(*store, job, {1, 1, 0}, 0);
    append(*store, job, {1, 0, 1}, 70'000);
    append(*store, job, {1, 0, 0});
  }
  const auto store = open();
  append(*store, job, {-1, 5, 0});
  std::vector<TaskId> tasks;
  for (const IndexedResult& result : results(*store, job)) {
    tasks.push_back(result.task);
    EXPECT_EQ(result.identity, info_of(job, result.task).identity);
    EXPECT_EQ(result.worker_name, "worker 1");
    EXPECT_EQ(result.worker_build, digest_of("a build"));
    EXPECT_EQ(result.samples, info_of(job, result.task).samples);
    EXPECT_EQ(result.rays, 123456789012);
    EXPECT_EQ(result.rejected, 2);
    EXPECT_EQ(result.seconds, 0.125);
    EXPECT_EQ(result.cpu_seconds, 0.25);
  }
  EXPECT_EQ(tasks, (std::vector<TaskId>{{-1, 5, 0}, {1, 0, 0}, {1, 0, 1}, {1, 1, 0}, {2, 0, 0}}));
  expect_readable(*store, job, 5);
  int of_frame = 0;
  store->results_of(
      job, 1, [&](const IndexedResult& result) { of_frame += result.task.frame == 1 ? 1 : 100; });
  EXPECT_EQ(of_frame, 3);
}

TEST_F(StoreTest, ASecondResultForATaskReplacesTheFirstInTheIndex) {
  const auto store = open();
  const JobId job = store->put_job(job_record());
  append(*store, job, {1, 0, 0}, 10);
  const ResultPlace second = append(*store, job, {1, 0, 0}, 20);
  ASSERT_EQ(results(*store, job).size(), 1);
  EXPECT_EQ(results(*store, job)[0].place, second);
}

TEST_F(StoreTest, SegmentsAreClosedBySizeAndDeletedWithTheirLastJob) {
  const auto store = open({.durable = false, .segment_bytes = 4000});
  const JobId one = store->put_job(job_record());
  const JobId two = store->put_job(job_record());
  for (std::uint32_t tile = 0; tile < 8; ++tile) append(*store, one, {1, tile, 0}, 1000);
  append(*store, two, {1, 0, 0}, 1000);
  for (std::uint32_t tile = 8; tile < 16; ++tile) append(*store, one, {1, tile, 0}, 1000);
  const std::size_t before = segments().size();
  EXPECT_GT(before, 4);
  const std::uint64_t bytes = store->journal_bytes();
  store->end_job(one);
  EXPECT_TRUE(results(*store, one).empty());
  expect_readable(*store, two, 1);
  EXPECT_LE(segments().size(), 2);
  EXPECT_LT(store->journal_bytes(), bytes / 2);
  std::uint64_t on_disk = 0;
  for (const auto& file : segments()) on_disk += std::filesystem::file_size(file);
  EXPECT_EQ(store->journal_bytes(), on_disk);
  store->end_job(two);
  EXPECT_LE(segments().size(), 1);
}

TEST_F(StoreTest, AGroupOfAnySizeIsReadBackAndTheNextBeginsBehindIt) {
  const auto store = open({.durable = true});
  const JobId job = store->put_job(job_record());
  for (const std::size_t size : {std::size_t{1}, std::size_t{4000}, 3 * limits::MiB}) {
    const auto tile = static_cast<std::uint32_t>(size);
    std::vector<std::vector<std::byte>> bytes;
    std::vector<NewResult> group;
    for (std::uint32_t pass = 0; pass < 3; ++pass) bytes.push_back(bytes_of({1, tile, pass}, size));
    for (std::uint32_t pass = 0; pass < 3; ++pass)
      group.push_back({info_of(job, {1, tile, pass}), "w", digest_of("a build"), bytes[pass]});
    store->append_results(group);
  }
  expect_readable(*store, job, 9);
}

TEST_F(StoreTest, ASecondCoordinatorIsRefusedByTheFoldersName) {
  auto store = open();
  const Error error = error_of([&] { static_cast<void>(open()); });
  EXPECT_EQ(error.kind(), ErrorKind::conflict);
  EXPECT_THAT(error.what(), HasSubstr(folder_.string()));
  EXPECT_THAT(error.what(), HasSubstr(std::to_string(::getpid())));
  store.reset();
  EXPECT_EQ(open()->epoch(), 2);
}

TEST_F(StoreTest, ReadersOnOtherThreadsSeeWholeResultsWhileTheWriterWrites) {
  const auto store = open();
  const JobId job = store->put_job(job_record());
  constexpr std::uint32_t tiles = 300;
  std::vector<std::thread> readers;
  std::atomic<bool> done{false};
  std::atomic<std::size_t> seen{0};
  for (int i = 0; i < 2; ++i) {
    readers.emplace_back([&] {
      while (!done) {
        std::size_t count = 0;
        for (const IndexedResult& result : results(*store, job)) {
          EXPECT_EQ(store->read_result(result.place).exr, bytes_of(result.task, 500));
          ++count;
        }
        seen = std::max<std::size_t>(seen, count);
      }
    });
  }
  for (std::uint32_t tile = 0; tile < tiles; ++tile) append(*store, job, {1, tile, 0}, 500);
  done = true;
  for (std::thread& reader : readers) reader.join();
  EXPECT_LE(seen, tiles);
  expect_readable(*store, job, tiles);
}

}  // namespace
}  // namespace tessera::server
