#include "server/store/schema.hpp"

#include <fmt/format.h>

#include <array>

namespace tessera::server {
namespace {

constexpr int application_id = 0x54535241;  // "TSRA"

// Step i brings version i to version i + 1. What has been released is never changed: a new version
// is a new step.
constexpr std::array<const char*, 6> steps{R"sql(
  CREATE TABLE meta(key TEXT PRIMARY KEY, value NOT NULL) WITHOUT ROWID;
  INSERT INTO meta VALUES('epoch', 0);

  CREATE TABLE jobs(
    id INTEGER PRIMARY KEY AUTOINCREMENT,
    spec TEXT NOT NULL,              -- JobSpec as JSON
    state TEXT NOT NULL,             -- JobView's words
    priority INTEGER NOT NULL,
    created INTEGER NOT NULL, started INTEGER NOT NULL, finished INTEGER NOT NULL,  -- Unix milliseconds, 0: not yet
    error TEXT NOT NULL,
    render_seconds REAL NOT NULL,
    rays INTEGER NOT NULL,
    rejected_samples INTEGER NOT NULL,
    shares TEXT NOT NULL);           -- [[worker, samples], …] as JSON

  CREATE TABLE workers(
    id INTEGER PRIMARY KEY,
    identity TEXT NOT NULL, name TEXT NOT NULL, build TEXT NOT NULL,
    UNIQUE(identity, name, build));

  -- The journal's index: a result is durable when its row is.
  CREATE TABLE results(
    job INTEGER NOT NULL, frame INTEGER NOT NULL, tile INTEGER NOT NULL, pass INTEGER NOT NULL,
    segment INTEGER NOT NULL, offset INTEGER NOT NULL, length INTEGER NOT NULL,
    worker INTEGER NOT NULL, samples INTEGER NOT NULL, rays INTEGER NOT NULL, rejected INTEGER NOT NULL,
    seconds REAL NOT NULL,
    PRIMARY KEY(job, frame, tile, pass)) WITHOUT ROWID;

  -- Which segment holds results of which job, and how long the segment is at least.
  CREATE TABLE segments(
    segment INTEGER NOT NULL, job INTEGER NOT NULL, ends INTEGER NOT NULL,
    PRIMARY KEY(segment, job)) WITHOUT ROWID;
)sql",
                                           R"sql(
  -- CPU time of the threads that rendered.
  ALTER TABLE jobs ADD COLUMN cpu_seconds REAL NOT NULL DEFAULT 0;
  ALTER TABLE results ADD COLUMN cpu_seconds REAL NOT NULL DEFAULT 0;
)sql",
                                           R"sql(
  -- Samples that the job had before it was extended, oldest first, as JSON.
  ALTER TABLE jobs ADD COLUMN extended_from TEXT NOT NULL DEFAULT '[]';

  -- A frame's film, whole, in the file of that number: there once its row is.
  CREATE TABLE checkpoints(
    job INTEGER NOT NULL, frame INTEGER NOT NULL, number INTEGER NOT NULL UNIQUE, bytes INTEGER NOT NULL,
    PRIMARY KEY(job, frame)) WITHOUT ROWID;
  CREATE TABLE checkpoint_tiles(
    job INTEGER NOT NULL, frame INTEGER NOT NULL, tile INTEGER NOT NULL,
    passes INTEGER NOT NULL,         -- folded in: [0, passes)
    offset INTEGER NOT NULL, length INTEGER NOT NULL,
    PRIMARY KEY(job, frame, tile)) WITHOUT ROWID;

  -- What results came to that a checkpoint holds: their own rows are gone.
  CREATE TABLE tallies(
    job INTEGER NOT NULL, worker INTEGER NOT NULL,
    samples INTEGER NOT NULL, rays INTEGER NOT NULL, rejected INTEGER NOT NULL, cpu_seconds REAL NOT NULL,
    PRIMARY KEY(job, worker)) WITHOUT ROWID;
)sql",
                                           R"sql(
  -- Attempts that gave no result: the newest of each job. `number` counts all of the job's, from 1.
  CREATE TABLE failures(
    job INTEGER NOT NULL, number INTEGER NOT NULL,
    frame INTEGER NOT NULL, tile INTEGER NOT NULL, pass INTEGER NOT NULL,  -- pass -1: its scene was being prepared
    epoch INTEGER NOT NULL, lease INTEGER NOT NULL,
    worker INTEGER NOT NULL, worker_name TEXT NOT NULL,
    outcome TEXT NOT NULL,
    started INTEGER NOT NULL, ended INTEGER NOT NULL,  -- Unix milliseconds, 0: not known
    reason TEXT NOT NULL, log TEXT NOT NULL,
    PRIMARY KEY(job, number)) WITHOUT ROWID;
  -- What who posted a job called the request, and a digest of what was posted.
  ALTER TABLE jobs ADD COLUMN idempotency_key TEXT NOT NULL DEFAULT '';
  ALTER TABLE jobs ADD COLUMN idempotency_fingerprint TEXT NOT NULL DEFAULT '';
)sql",
                                           R"sql(
  -- Workers that are granted nothing until they are released: all of that name.
  CREATE TABLE quarantines(
    name TEXT PRIMARY KEY,
    reason TEXT NOT NULL,
    imposed_by TEXT NOT NULL,        -- "user", "server"
    since INTEGER NOT NULL) WITHOUT ROWID;  -- Unix milliseconds
  -- Samples that were asked for, where time was up before they were made; 0: it was not.
  ALTER TABLE jobs ADD COLUMN shortened_from INTEGER NOT NULL DEFAULT 0;
)sql",
                                           R"sql(
  -- Frames of jobs of several that ended by their noise: samples of each pixel that they have.
  CREATE TABLE shortened_frames(
    job INTEGER NOT NULL, frame INTEGER NOT NULL, samples INTEGER NOT NULL,
    PRIMARY KEY(job, frame)) WITHOUT ROWID;
)sql"};

}  // namespace

int schema_version() { return static_cast<int>(steps.size()); }

void migrate(Database& database, const std::string& name) {
  const std::int64_t version = database.integer("PRAGMA user_version");
  const std::int64_t owner = database.integer("PRAGMA application_id");
  if (owner != application_id &&
      (version != 0 || database.integer("SELECT count(*) FROM sqlite_master") != 0)) {
    throw Error(ErrorKind::conflict, fmt::format("{} is a database of another program", name));
  }
  if (version > schema_version()) {
    throw Error(ErrorKind::conflict,
                fmt::format("{} was written by a newer Tessera (schema {}; this one knows {}): use "
                            "that one, or another data folder",
                            name, version, schema_version()));
  }
  for (std::int64_t step = version; step < schema_version(); ++step) {
    Transaction transaction(database);
    database.execute(steps.at(static_cast<std::size_t>(step)));
    database.execute(fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {}",
                                 application_id, step + 1));
    transaction.commit();
  }
}

}  // namespace tessera::server
