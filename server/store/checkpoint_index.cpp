#include <fmt/format.h>

#include <algorithm>

#include "common/base/error.hpp"
#include "server/store/index.hpp"

/// The index's tables of checkpoints, and of what their results came to.
namespace tessera::server {

namespace {

Checkpoint checkpoint_from(const Statement& row, JobId job) {
  Checkpoint checkpoint;
  checkpoint.job = job;
  checkpoint.frame = static_cast<std::int32_t>(row.integer(0));
  checkpoint.number = static_cast<std::uint64_t>(row.integer(1));
  checkpoint.bytes = static_cast<std::uint64_t>(row.integer(2));
  return checkpoint;
}

void read_tiles(Database& database, Checkpoint& checkpoint) {
  Statement rows = database.prepare(
      "SELECT tile, passes, offset, length FROM checkpoint_tiles WHERE job = ?1 AND frame = ?2 "
      "ORDER BY tile");
  for (bool more = rows.run(checkpoint.job, checkpoint.frame); more; more = rows.step())
    checkpoint.tiles.push_back(
        {static_cast<std::uint32_t>(rows.integer(0)), static_cast<std::uint32_t>(rows.integer(1)),
         static_cast<std::uint64_t>(rows.integer(2)), static_cast<std::uint64_t>(rows.integer(3))});
}

/// Throws unless every pass that the old one holds is in the new one.
void check_covers(const Checkpoint& before, const Checkpoint& after) {
  auto at = after.tiles.begin();
  for (const CheckpointTile& tile : before.tiles) {
    while (at != after.tiles.end() && at->tile < tile.tile) ++at;
    if (at == after.tiles.end() || at->tile != tile.tile || at->passes < tile.passes)
      throw Error(ErrorKind::failed,
                  fmt::format("a checkpoint of job {} frame {} holds less of tile {} than the one "
                              "that it was to take the place of",
                              before.job, before.frame, tile.tile));
  }
}

}  // namespace

void Index::drop_unused_segments(JobId job) {
  writer_
      .prepare(
          "DELETE FROM segments WHERE job = ?1 AND segment NOT IN (SELECT segment FROM results "
          "WHERE job = ?1)")
      .run(job);
  supersede_failed_commits();
}

std::optional<std::uint64_t> Index::put_checkpoint(const Checkpoint& checkpoint) {
  const JobId job = checkpoint.job;
  const std::int32_t frame = checkpoint.frame;
  const std::optional<Checkpoint> before = checkpoint_of(job, frame);
  if (before) check_covers(*before, checkpoint);
  Transaction transaction(writer_);
  writer_.prepare("DELETE FROM checkpoint_tiles WHERE job = ?1 AND frame = ?2").run(job, frame);
  writer_.prepare("INSERT OR REPLACE INTO checkpoints VALUES(?1, ?2, ?3, ?4)")
      .run(job, frame, checkpoint.number, checkpoint.bytes);
  Statement add = writer_.prepare("INSERT INTO checkpoint_tiles VALUES(?1, ?2, ?3, ?4, ?5, ?6)");
  for (const CheckpointTile& tile : checkpoint.tiles)
    add.run(job, frame, tile.tile, tile.passes, tile.offset, tile.length);
  writer_
      .prepare(
          "INSERT INTO tallies SELECT r.job, r.worker, sum(r.samples), sum(r.rays), "
          "sum(r.rejected), sum(r.cpu_seconds) FROM results r JOIN checkpoint_tiles c ON c.job = "
          "r.job AND c.frame = r.frame AND c.tile = r.tile WHERE r.job = ?1 AND r.frame = ?2 AND "
          "r.pass < c.passes GROUP BY r.worker ON CONFLICT(job, worker) DO UPDATE SET samples = "
          "samples + excluded.samples, rays = rays + excluded.rays, rejected = rejected + "
          "excluded.rejected, cpu_seconds = cpu_seconds + excluded.cpu_seconds")
      .run(job, frame);
  writer_
      .prepare(
          "DELETE FROM results WHERE job = ?1 AND frame = ?2 AND pass < coalesce((SELECT passes "
          "FROM checkpoint_tiles c WHERE c.job = ?1 AND c.frame = ?2 AND c.tile = results.tile), "
          "0)")
      .run(job, frame);
  drop_unused_segments(job);
  transaction.commit();
  if (!before) return std::nullopt;
  return before->number;
}

std::optional<Checkpoint> Index::checkpoint_of(JobId job, std::int32_t frame) const {
  const std::lock_guard lock(reading_);
  Statement row = reader_->prepare(
      "SELECT frame, number, bytes FROM checkpoints WHERE job = ?1 AND frame = ?2");
  if (!row.run(job, frame)) return std::nullopt;
  Checkpoint checkpoint = checkpoint_from(row, job);
  read_tiles(*reader_, checkpoint);
  return checkpoint;
}

std::vector<JobId> Index::jobs_with_checkpoints() const {
  const std::lock_guard lock(reading_);
  std::vector<JobId> jobs;
  Statement rows = reader_->prepare("SELECT DISTINCT job FROM checkpoints ORDER BY job");
  for (bool more = rows.run(); more; more = rows.step())
    jobs.push_back(static_cast<JobId>(rows.integer(0)));
  return jobs;
}

std::vector<Checkpoint> Index::checkpoints_of(JobId job) const {
  const std::lock_guard lock(reading_);
  std::vector<Checkpoint> found;
  Statement rows = reader_->prepare(
      "SELECT frame, number, bytes FROM checkpoints WHERE job = ?1 ORDER BY frame");
  for (bool more = rows.run(job); more; more = rows.step())
    found.push_back(checkpoint_from(rows, job));
  for (Checkpoint& checkpoint : found) read_tiles(*reader_, checkpoint);
  return found;
}

std::vector<IndexedFile> Index::indexed_checkpoints() const {
  return indexed_files("SELECT number, job, bytes FROM checkpoints ORDER BY number");
}

std::set<std::uint64_t> Index::checkpoint_numbers() const {
  std::set<std::uint64_t> numbers;
  for (const IndexedFile& file : indexed_checkpoints()) numbers.insert(file.number);
  return numbers;
}

std::vector<Tally> Index::tallies_of(JobId job) const {
  const std::lock_guard lock(reading_);
  Statement rows = reader_->prepare(
      "SELECT name, build, samples, rays, rejected, cpu_seconds FROM tallies JOIN workers ON "
      "workers.id = worker WHERE job = ?1 ORDER BY worker");
  std::vector<Tally> tallies;
  for (bool more = rows.run(job); more; more = rows.step()) {
    int column = 0;
    Tally tally;
    tally.worker_name = rows.text(column++);
    tally.worker_build = Digest::from_hex(rows.text(column++)).value_or(Digest{});
    tally.samples = rows.integer(column++);
    tally.rays = rows.integer(column++);
    tally.rejected = rows.integer(column++);
    tally.cpu_seconds = rows.number(column++);
    tallies.push_back(std::move(tally));
  }
  return tallies;
}

void Index::extend_job(const JobRecord& record, std::uint32_t passes) {
  Transaction transaction(writer_);
  update_job(record);
  writer_.prepare("DELETE FROM results WHERE job = ?1 AND pass >= ?2").run(record.id, passes);
  writer_.prepare("DELETE FROM shortened_frames WHERE job = ?1").run(record.id);
  drop_unused_segments(record.id);
  transaction.commit();
}

void Index::forget_job(JobId job) {
  Transaction transaction(writer_);
  delete_results(job);
  delete_checkpoints(job);
  for (const char* table : {"failures", "shortened_frames"})
    writer_.prepare(fmt::format("DELETE FROM {} WHERE job = ?1", table)).run(job);
  writer_.prepare("DELETE FROM jobs WHERE id = ?1").run(job);
  transaction.commit();
}

void Index::delete_checkpoints(JobId job) {
  for (const char* table : {"checkpoints", "checkpoint_tiles", "tallies"})
    writer_.prepare(fmt::format("DELETE FROM {} WHERE job = ?1", table)).run(job);
}

}  // namespace tessera::server
