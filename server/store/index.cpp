#include "server/store/index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/base/json.hpp"
#include "common/base/random.hpp"
#include "server/store/schema.hpp"

namespace tessera::server {
namespace {

constexpr std::string_view job_columns =
    "id, spec, state, priority, created, started, finished, error, render_seconds, rays, "
    "rejected_samples, shares, cpu_seconds, extended_from, idempotency_key, "
    "idempotency_fingerprint, shortened_from";

Database opened(const std::filesystem::path& file, bool durable, const char* vfs) {
  Database database(file, Database::Mode::read_write, vfs);
  database.execute("PRAGMA journal_mode = WAL");
  database.execute(durable ? "PRAGMA synchronous = FULL" : "PRAGMA synchronous = OFF");
  migrate(database, file.string());
  return database;
}

JobRecord job_from(const Statement& row, const std::filesystem::path& name) {
  int column = 0;
  JobRecord job;
  job.id = static_cast<JobId>(row.integer(column++));
  job.spec = job_spec_from_json(parse_json(row.text(column++), name.string()));
  job.state = row.text(column++);
  job.priority = static_cast<int>(row.integer(column++));
  job.created = row.integer(column++);
  job.started = row.integer(column++);
  job.finished = row.integer(column++);
  job.error = row.text(column++);
  job.render_seconds = row.number(column++);
  job.rays = row.integer(column++);
  job.rejected_samples = row.integer(column++);
  for (const Json& share : parse_json(row.text(column++), name.string())) {
    job.shares.push_back({share.at(0).get<std::string>(), share.at(1).get<std::int64_t>()});
  }
  job.cpu_seconds = row.number(column++);
  job.extended_from =
      parse_json(row.text(column++), name.string()).get<std::vector<std::int64_t>>();
  job.idempotency_key = row.text(column++);
  job.idempotency_fingerprint = row.text(column++);
  job.shortened_from = row.integer(column++);
  return job;
}

std::string shares_text(const JobRecord& record) {
  Json shares = Json::array();
  for (const JobRecord::Share& share : record.shares)
    shares.push_back(Json::array({share.worker, share.samples}));
  return shares.dump();
}

}  // namespace

Index::Index(const std::filesystem::path& file, bool durable, const char* vfs)
    : writer_(opened(file, durable, vfs)),
      reader_(Database(file, Database::Mode::read_only, vfs)),
      add_result_(writer_.prepare("INSERT OR REPLACE INTO results VALUES(?1, ?2, ?3, ?4, ?5, ?6, "
                                  "?7, ?8, ?9, ?10, ?11, ?12, ?13)")),
      add_segment_(writer_.prepare("INSERT INTO segments VALUES(?1, ?2, ?3) ON CONFLICT DO UPDATE "
                                   "SET ends = max(ends, ?3)")),
      add_worker_(writer_.prepare("INSERT INTO workers(identity, name, build) VALUES(?1, ?2, ?3)")),
      find_worker_(writer_.prepare(
          "SELECT id FROM workers WHERE identity = ?1 AND name = ?2 AND build = ?3")) {}

std::uint64_t Index::next_epoch() {
  Transaction transaction(writer_);
  writer_.execute("UPDATE meta SET value = value + 1 WHERE key = 'epoch'");
  const std::int64_t epoch = writer_.integer("SELECT value FROM meta WHERE key = 'epoch'");
  transaction.commit();
  return static_cast<std::uint64_t>(epoch);
}

std::string Index::grant_key() {
  constexpr std::size_t key_bytes = 16;
  writer_.prepare("INSERT OR IGNORE INTO meta VALUES('grant_key', ?1)").run(random_hex(key_bytes));
  Statement find = writer_.prepare("SELECT value FROM meta WHERE key = 'grant_key'");
  find.run();
  return find.text(0);
}

JobId Index::put_job(const JobRecord& record) {
  Statement insert = writer_.prepare(
      "INSERT INTO jobs(spec, state, priority, created, started, finished, error, render_seconds, "
      "rays, rejected_samples, "
      "shares, cpu_seconds, idempotency_key, idempotency_fingerprint) VALUES(?1, ?2, ?3, ?4, ?5, "
      "?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14)");
  insert.run(to_json(record.spec).dump(), record.state, record.priority, record.created,
             record.started, record.finished, record.error, record.render_seconds, record.rays,
             record.rejected_samples, shares_text(record), record.cpu_seconds,
             record.idempotency_key, record.idempotency_fingerprint);
  return static_cast<JobId>(writer_.last_row());
}

void Index::skip_jobs(JobId last) {
  const std::int64_t given =
      writer_.integer("SELECT coalesce(max(seq), 0) FROM sqlite_sequence WHERE name = 'jobs'");
  if (last <= static_cast<JobId>(given)) return;
  Transaction transaction(writer_);
  writer_.execute("DELETE FROM sqlite_sequence WHERE name = 'jobs'");
  writer_.prepare("INSERT INTO sqlite_sequence(name, seq) VALUES('jobs', ?1)").run(last);
  transaction.commit();
}

void Index::update_job(const JobRecord& record) {
  Statement update = writer_.prepare(
      "UPDATE jobs SET state = ?2, priority = ?3, created = ?4, started = ?5, finished = ?6, error "
      "= ?7, render_seconds = ?8, "
      "rays = ?9, rejected_samples = ?10, shares = ?11, cpu_seconds = ?12, spec = ?13, "
      "extended_from = ?14, shortened_from = ?15 WHERE id = ?1 RETURNING id");
  const bool found = update.run(
      record.id, record.state, record.priority, record.created, record.started, record.finished,
      record.error, record.render_seconds, record.rays, record.rejected_samples,
      shares_text(record), record.cpu_seconds, to_json(record.spec).dump(),
      Json(record.extended_from).dump(), record.shortened_from);
  if (!found) throw Error(ErrorKind::not_found, fmt::format("there is no job {}", record.id));
  update.step();  // to its end: only then is it committed
}

void Index::shorten_frame(JobId job, std::int32_t frame, std::int64_t samples) {
  Statement put = writer_.prepare(
      "INSERT OR REPLACE INTO shortened_frames SELECT id, ?2, ?3 FROM jobs WHERE id = ?1 RETURNING "
      "job");
  if (!put.run(job, frame, samples))
    throw Error(ErrorKind::not_found, fmt::format("there is no job {}", job));
  put.step();  // to its end: only then is it committed
}

void Index::unshorten_frame(JobId job, std::int32_t frame) {
  writer_.prepare("DELETE FROM shortened_frames WHERE job = ?1 AND frame = ?2").run(job, frame);
}

std::vector<JobRecord> Index::list_jobs() const {
  const std::lock_guard lock(reading_);
  Statement rows = reader_->prepare(fmt::format("SELECT {} FROM jobs ORDER BY id", job_columns));
  std::vector<JobRecord> jobs;
  for (bool more = rows.run(); more; more = rows.step()) jobs.push_back(job_from(rows, "jobs"));
  Statement frames =
      reader_->prepare("SELECT job, frame, samples FROM shortened_frames ORDER BY job, frame");
  auto job = jobs.begin();
  for (bool more = frames.run(); more; more = frames.step()) {
    const auto id = static_cast<JobId>(frames.integer(0));
    while (job != jobs.end() && job->id < id) ++job;
    if (job == jobs.end() || job->id != id) continue;
    job->shortened_frames[static_cast<std::int32_t>(frames.integer(1))] = frames.integer(2);
  }
  return jobs;
}

std::int64_t Index::worker_row(const NewResult& result) {
  const std::string build = result.worker_build.hex();
  const std::string key =
      fmt::format("{}\n{}\n{}", result.info.identity, result.worker_name, build);
  const auto known = worker_rows_.find(key);
  if (known != worker_rows_.end()) return known->second;
  std::int64_t row = 0;
  if (find_worker_.run(result.info.identity, result.worker_name, build)) {
    row = find_worker_.integer(0);
    find_worker_.reset();
  } else {
    add_worker_.run(result.info.identity, result.worker_name, build);
    row = writer_.last_row();
  }
  worker_rows_.emplace(key, row);
  return row;
}

void Index::add_results(std::span<const NewResult> batch, std::span<const ResultPlace> places) {
  std::map<std::pair<std::uint64_t, JobId>, std::uint64_t> ends;
  try {
    Transaction transaction(writer_);
    for (std::size_t i = 0; i < batch.size(); ++i) {
      const ResultInfo& info = batch[i].info;
      const ResultPlace& place = places[i];
      add_result_.run(info.job, info.task.frame, info.task.tile, info.task.pass, place.segment,
                      place.offset, place.length, worker_row(batch[i]), info.samples, info.rays,
                      info.rejected, info.seconds, info.cpu_seconds);
      std::uint64_t& end = ends[{place.segment, info.job}];
      end = std::max(end, place.offset + place.length);
    }
    for (const auto& [key, end] : ends) add_segment_.run(key.first, key.second, end);
    transaction.commit();
  } catch (...) {
    worker_rows_.clear();  // rows of this transaction are gone
    throw;
  }
}

void Index::results_of(JobId job, std::optional<std::int32_t> frame,
                       const std::function<void(const IndexedResult&)>& visit) const {
  const std::lock_guard lock(reading_);
  const std::string sql = fmt::format(
      "SELECT frame, tile, pass, segment, offset, length, samples, rays, rejected, seconds, "
      "worker, "
      "cpu_seconds FROM results "
      "WHERE job = ?1 {} ORDER BY frame, tile, pass",
      frame ? "AND frame = ?2" : "");
  struct Worker {
    std::string identity, name;
    Digest build;
  };
  std::unordered_map<std::int64_t, Worker> workers;
  Statement find = reader_->prepare("SELECT identity, name, build FROM workers WHERE id = ?1");
  Statement rows = reader_->prepare(sql);
  for (bool more = frame ? rows.run(job, *frame) : rows.run(job); more; more = rows.step()) {
    const auto [worker, fresh] = workers.try_emplace(rows.integer(10));
    if (fresh && find.run(worker->first)) {
      worker->second = {find.text(0), find.text(1),
                        Digest::from_hex(find.text(2)).value_or(Digest{})};
      find.reset();
    }
    IndexedResult result;
    result.task = {static_cast<std::int32_t>(rows.integer(0)),
                   static_cast<std::uint32_t>(rows.integer(1)),
                   static_cast<std::uint32_t>(rows.integer(2))};
    result.place = {static_cast<std::uint64_t>(rows.integer(3)),
                    static_cast<std::uint64_t>(rows.integer(4)),
                    static_cast<std::uint64_t>(rows.integer(5))};
    result.samples = rows.integer(6);
    result.rays = rows.integer(7);
    result.rejected = rows.integer(8);
    result.seconds = rows.number(9);
    result.cpu_seconds = rows.number(11);
    result.identity = worker->second.identity;
    result.worker_name = worker->second.name;
    result.worker_build = worker->second.build;
    visit(result);
  }
}

std::vector<JobId> Index::jobs_with_results() const {
  const std::lock_guard lock(reading_);
  std::vector<JobId> jobs;
  Statement rows = reader_->prepare("SELECT DISTINCT job FROM segments ORDER BY job");
  for (bool more = rows.run(); more; more = rows.step())
    jobs.push_back(static_cast<JobId>(rows.integer(0)));
  return jobs;
}

/// A commit that failed can come to light after a restart, with rows that name files of which this
/// connection knows nothing. The transaction that does this takes its place in the log for sure,
/// for it changes something: once it is committed, files without rows may be deleted.
void Index::supersede_failed_commits() {
  writer_.execute(
      "INSERT INTO meta VALUES('commits', 1) ON CONFLICT DO UPDATE SET value = value + 1");
}

void Index::delete_results(JobId job) {
  writer_.prepare("DELETE FROM results WHERE job = ?1").run(job);
  writer_.prepare("DELETE FROM segments WHERE job = ?1").run(job);
  supersede_failed_commits();
}

void Index::forget_results(JobId job) {
  Transaction transaction(writer_);
  delete_results(job);
  transaction.commit();
}

void Index::end_job(JobId job) {
  Transaction transaction(writer_);
  delete_results(job);
  delete_checkpoints(job);
  transaction.commit();
}

std::vector<IndexedFile> Index::indexed_files(const char* sql) const {
  const std::lock_guard lock(reading_);
  std::vector<IndexedFile> files;
  Statement rows = reader_->prepare(sql);
  for (bool more = rows.run(); more; more = rows.step())
    files.push_back({static_cast<std::uint64_t>(rows.integer(0)),
                     static_cast<JobId>(rows.integer(1)),
                     static_cast<std::uint64_t>(rows.integer(2))});
  return files;
}

std::vector<IndexedFile> Index::indexed_segments() const {
  return indexed_files("SELECT segment, job, ends FROM segments ORDER BY segment, job");
}

std::set<std::uint64_t> Index::segments() const {
  std::set<std::uint64_t> numbers;
  for (const IndexedFile& file : indexed_segments()) numbers.insert(file.number);
  return numbers;
}

}  // namespace tessera::server
