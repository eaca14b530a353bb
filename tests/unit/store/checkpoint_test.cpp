// Checkpoints: exact, whole or not there, and never less than what they take the place of.
#include <gmock/gmock.h>

#include "server/store/database.hpp"
#include "tests/unit/store/store_fixture.hpp"

namespace tessera::server {
namespace {

using ::testing::HasSubstr;

class CheckpointTest : public StoreTest {
 protected:
  std::unique_ptr<Store> store = open();
  JobId job = store->put_job(job_record());

  static std::vector<std::byte> content(std::uint32_t tile, std::uint32_t passes) {
    return bytes_of({1, tile, passes}, 1000 + 10 * tile);
  }
  /// Tiles 0, 1, … with these passes; 0: nothing.
  [[nodiscard]] Checkpoint write(const std::vector<std::uint32_t>& passes, int frame = 1) const {
    const auto writer = store->begin_checkpoint(job, frame);
    for (std::uint32_t tile = 0; tile < passes.size(); ++tile)
      if (passes[tile] > 0) writer->append(tile, passes[tile], content(tile, passes[tile]));
    return writer->finish();
  }
  static CheckpointPlace place(const Checkpoint& of, std::size_t index) {
    return {of.number, of.tiles[index].offset, of.tiles[index].length};
  }
  [[nodiscard]] std::size_t files() const {
    const std::filesystem::directory_iterator all(folder_ / "checkpoints");
    return static_cast<std::size_t>(std::distance(begin(all), end(all)));
  }
};

TEST_F(CheckpointTest, GivesBackWhatWasPutInAlsoAfterAReopen) {
  const Checkpoint made = write({2, 0, 3});
  store->put_checkpoint(made);
  store.reset();
  store = open();
  const auto found = store->checkpoint_of(job, 1);
  ASSERT_TRUE(found);
  EXPECT_EQ(*found, made);
  ASSERT_EQ(found->tiles.size(), 2U);
  EXPECT_EQ(store->read_checkpoint(place(*found, 0)), content(0, 2));
  EXPECT_EQ(store->read_checkpoint(place(*found, 1)), content(2, 3));
  EXPECT_FALSE(store->checkpoint_of(job, 2));
  EXPECT_EQ(store->checkpoints_of(job), std::vector<Checkpoint>{made});
  EXPECT_EQ(store->checkpoint_bytes(), made.bytes);
}

TEST_F(CheckpointTest, TakesThePlaceOfTheResultsThatItHoldsAndOfNoOthers) {
  for (std::uint32_t tile = 0; tile < 3; ++tile)
    for (std::uint32_t pass = 0; pass < 3; ++pass) append(*store, job, {1, tile, pass});
  append(*store, job, {2, 0, 0});
  store->put_checkpoint(write({2, 0, 3}));
  std::vector<TaskId> left;
  for (const IndexedResult& result : results(*store, job)) left.push_back(result.task);
  EXPECT_EQ(left, (std::vector<TaskId>{{1, 0, 2}, {1, 1, 0}, {1, 1, 1}, {1, 1, 2}, {2, 0, 0}}));
  expect_readable(*store, job, 5);
}

TEST_F(CheckpointTest, CountsWhatItTakesThePlaceOfByWorker) {
  append(*store, job, {1, 0, 0});
  append(*store, job, {1, 0, 1});
  store->put_checkpoint(write({1}));
  store->put_checkpoint(write({2}));
  store->put_checkpoint(write({2}));
  const auto tallies = store->tallies_of(job);
  ASSERT_EQ(tallies.size(), 1U);
  EXPECT_EQ(tallies[0].worker_name, "worker 1");
  EXPECT_EQ(tallies[0].worker_build, digest_of("a build"));
  EXPECT_EQ(tallies[0].samples, 4096 * 3);
  EXPECT_EQ(tallies[0].rays, 2 * 123456789012);
  EXPECT_EQ(tallies[0].rejected, 4);
  EXPECT_EQ(tallies[0].cpu_seconds, 0.5);
}

TEST_F(CheckpointTest, SegmentsWhoseResultsItHoldsAreDeleted) {
  store.reset();
  store = open({.durable = false, .segment_bytes = 1});  // a segment a result
  append(*store, job, {1, 0, 0});
  append(*store, job, {1, 0, 1});
  append(*store, job, {1, 0, 2});
  ASSERT_EQ(segments().size(), 3U);
  store->put_checkpoint(write({2}));
  EXPECT_EQ(segments().size(), 1U);
  expect_readable(*store, job, 1);
}

TEST_F(CheckpointTest, OfOneFrameThereIsOne) {
  store->put_checkpoint(write({1}));
  const Checkpoint second = write({2});
  EXPECT_EQ(files(), 2U);
  store->put_checkpoint(second);
  EXPECT_EQ(files(), 1U);
  EXPECT_EQ(store->checkpoint_of(job, 1), second);
}

TEST_F(CheckpointTest, ThatHoldsLessThanTheOneBeforeIsRefused) {
  const Checkpoint first = write({2, 2});
  store->put_checkpoint(first);
  for (const auto& passes : std::vector<std::vector<std::uint32_t>>{{1, 2}, {2, 0}, {0, 2}})
    EXPECT_THAT(error_of([&] { store->put_checkpoint(write(passes)); }).what(),
                HasSubstr("holds less"));
  EXPECT_EQ(store->checkpoint_of(job, 1), first);
  EXPECT_EQ(store->read_checkpoint(place(first, 1)), content(1, 2));
}

TEST_F(CheckpointTest, ThatNothingNamesIsGone) {
  { const auto dropped = store->begin_checkpoint(job, 1); }
  EXPECT_EQ(files(), 0U);
  static_cast<void>(write({1}));  // killed before it was put
  EXPECT_EQ(files(), 1U);
  store.reset();
  store = open();
  EXPECT_EQ(files(), 0U);
  EXPECT_EQ(store->checkpoint_bytes(), 0U);
}

TEST_F(CheckpointTest, OneThatIsDiscardedIsGoneUnlessItCounts) {
  const Checkpoint kept = write({1});
  store->put_checkpoint(kept);
  const Checkpoint refused = write({1, 2});
  EXPECT_EQ(files(), 2U);
  store->discard_checkpoint(refused);
  store->discard_checkpoint(kept);
  EXPECT_EQ(files(), 2U) << "its commit may yet come to light";
  store->forget_results(job);
  EXPECT_EQ(files(), 1U);
  EXPECT_EQ(store->read_checkpoint(place(kept, 0)), content(0, 1));
}

TEST_F(CheckpointTest, DamagedOneIsSaidToBe) {
  const Checkpoint made = write({1});
  store->put_checkpoint(made);
  const auto file = folder_ / "checkpoints" / "00000001.checkpoint";
  {
    std::fstream bytes(file, std::ios::in | std::ios::out | std::ios::binary);
    bytes.seekp(static_cast<std::streamoff>(made.tiles[0].offset) + 100);
    bytes.put('\x7f');
  }
  EXPECT_THAT(error_of([&] { static_cast<void>(store->read_checkpoint(place(made, 0))); }).what(),
              HasSubstr("00000001.checkpoint"));
  store.reset();
  std::filesystem::resize_file(file, made.bytes - 1);
  store = open();
  ASSERT_TRUE(store->damage().contains(job));
  EXPECT_THAT(store->damage().at(job), HasSubstr("00000001.checkpoint"));
  EXPECT_TRUE(store->checkpoint_of(job, 1)) << "its place is kept: the file may come back";
}

TEST_F(CheckpointTest, GoesWithItsJobAndNotWithItsResults) {
  append(*store, job, {1, 0, 1});
  store->put_checkpoint(write({1}));
  store->forget_results(job);
  EXPECT_TRUE(results(*store, job).empty());
  EXPECT_TRUE(store->jobs_with_results().empty());
  EXPECT_TRUE(store->checkpoint_of(job, 1));
  EXPECT_EQ(store->jobs_with_checkpoints(), std::vector<JobId>{job});
  store->end_job(job);
  EXPECT_FALSE(store->checkpoint_of(job, 1));
  EXPECT_TRUE(store->jobs_with_checkpoints().empty());
  EXPECT_EQ(files(), 0U);
}

TEST_F(CheckpointTest, ExtendedJobHasItsSamplesAndLosesTheResultsOfItsLastPass) {
  for (std::uint32_t pass = 0; pass < 4; ++pass) append(*store, job, {1, 0, pass});
  JobRecord more = job_record();
  more.id = job;
  more.extended_from = {20};
  more.spec.render.samples = 100;
  more.state = "queued";
  store->extend_job(more, 3);
  store.reset();
  store = open();
  const auto jobs = store->list_jobs();
  ASSERT_EQ(jobs.size(), 1U);
  EXPECT_EQ(jobs[0].spec, more.spec);
  EXPECT_EQ(jobs[0].extended_from, std::vector<std::int64_t>{20});
  expect_readable(*store, job, 3);
  // Whoever saves it as it was before takes both back: they never disagree.
  JobRecord before = job_record();
  before.id = job;
  store->update_job(before);
  EXPECT_EQ(store->list_jobs().at(0).spec, before.spec);
  EXPECT_TRUE(store->list_jobs().at(0).extended_from.empty());
  more.id = 77;
  EXPECT_EQ(error_of([&] { store->extend_job(more, 0); }).kind(), ErrorKind::not_found);
}

TEST_F(CheckpointTest, DatabaseOfTheSchemaBeforeIsReadOn) {
  append(*store, job, {1, 0, 0});
  store.reset();
  {
    Database old(folder_ / "tessera.db", Database::Mode::read_write);
    for (const char* table : {"checkpoints", "checkpoint_tiles", "tallies", "failures",
                              "quarantines", "shortened_frames"})
      old.execute(std::string("DROP TABLE ") + table);
    for (const char* column :
         {"extended_from", "idempotency_key", "idempotency_fingerprint", "shortened_from"})
      old.execute(std::string("ALTER TABLE jobs DROP COLUMN ") + column);
    old.execute("PRAGMA user_version = 2");
  }
  store = open();
  expect_readable(*store, job, 1);
  EXPECT_TRUE(store->list_jobs().at(0).extended_from.empty());
  store->put_checkpoint(write({1}));
  EXPECT_TRUE(store->checkpoint_of(job, 1));
}

}  // namespace
}  // namespace tessera::server
