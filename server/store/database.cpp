#include "server/store/database.hpp"

#include <fmt/format.h>
#include <sqlite3.h>

#include "common/base/log.hpp"

namespace tessera::server {
namespace {

[[noreturn]] void fail(sqlite3* database, int code) {
  const char* name = database != nullptr ? sqlite3_db_filename(database, "main") : nullptr;
  const std::string file = name != nullptr ? name : "the database";
  const int primary = code & 0xff;
  const std::string why = database != nullptr ? sqlite3_errmsg(database) : sqlite3_errstr(code);
  const char* what =
      primary == SQLITE_CORRUPT || primary == SQLITE_NOTADB ? "is damaged" : "could not be used";
  throw DatabaseError(primary == SQLITE_FULL ? ErrorKind::no_room : ErrorKind::failed,
                      fmt::format("{} {}: {}", file, what, why), code);
}

}  // namespace

bool DatabaseError::disk_full() const { return (code_ & 0xff) == SQLITE_FULL; }

void Statement::Closer::operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }

Statement::Statement(sqlite3* database, std::string_view sql) : database_(database) {
  sqlite3_stmt* made = nullptr;
  const int code = sqlite3_prepare_v3(database, sql.data(), static_cast<int>(sql.size()),
                                      SQLITE_PREPARE_PERSISTENT, &made, nullptr);
  statement_.reset(made);
  check(code);
}

void Statement::check(int code) const {
  if (code != SQLITE_OK) fail(database_, sqlite3_extended_errcode(database_));
}

bool Statement::step() {
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  if (code != SQLITE_DONE) {
    const int extended = sqlite3_extended_errcode(database_);
    try {
      fail(database_, extended);
    } catch (...) {
      reset();  // only now: it forgets the message
      throw;
    }
  }
  reset();
  return false;
}

void Statement::reset() { sqlite3_reset(statement_.get()); }

std::int64_t Statement::integer(int column) const {
  return sqlite3_column_int64(statement_.get(), column);
}
double Statement::number(int column) const {
  return sqlite3_column_double(statement_.get(), column);
}
std::string Statement::text(int column) const {
  const auto* bytes = static_cast<const char*>(sqlite3_column_blob(statement_.get(), column));
  const int size = sqlite3_column_bytes(statement_.get(), column);
  return bytes != nullptr ? std::string(bytes, static_cast<std::size_t>(size)) : std::string();
}

void Statement::bind(int index, std::int64_t value) {
  check(sqlite3_bind_int64(statement_.get(), index, value));
}
void Statement::bind(int index, double value) {
  check(sqlite3_bind_double(statement_.get(), index, value));
}
void Statement::bind(int index, const std::string& value) {
  // The text lives until the statement has run, but may be read again by a later reset: SQLite
  // keeps its own copy.
  check(sqlite3_bind_text64(statement_.get(), index, value.data(), value.size(), SQLITE_TRANSIENT,
                            SQLITE_UTF8));
}

void Database::Closer::operator()(sqlite3* database) const { sqlite3_close(database); }

Database::Database(const std::filesystem::path& file, Mode mode, const char* vfs) {
  const int flags = (mode == Mode::read_write ? SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE
                                              : SQLITE_OPEN_READONLY) |
                    SQLITE_OPEN_NOMUTEX;
  sqlite3* made = nullptr;
  const int code = sqlite3_open_v2(file.c_str(), &made, flags, vfs);
  database_.reset(made);
  if (code != SQLITE_OK) {
    throw DatabaseError(
        ErrorKind::failed,
        fmt::format("{} could not be opened: {}", file.string(), sqlite3_errstr(code)), code);
  }
  constexpr int patience_ms = 5000;
  sqlite3_busy_timeout(made, patience_ms);
  sqlite3_extended_result_codes(made, 1);
}

void Database::execute(const std::string& sql) {
  if (sqlite3_exec(database_.get(), sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) {
    fail(database_.get(), sqlite3_extended_errcode(database_.get()));
  }
}

Statement Database::prepare(std::string_view sql) { return {database_.get(), sql}; }

std::int64_t Database::integer(std::string_view sql) {
  Statement statement = prepare(sql);
  if (!statement.run())
    throw DatabaseError(ErrorKind::failed, fmt::format("nothing found by: {}", sql), SQLITE_ERROR);
  return statement.integer(0);
}

std::int64_t Database::last_row() const { return sqlite3_last_insert_rowid(database_.get()); }

Transaction::Transaction(Database& database) : database_(database) {
  database_.execute("BEGIN IMMEDIATE");
}

Transaction::~Transaction() {
  if (!open_) return;
  try {
    database_.execute("ROLLBACK");
  } catch (const Error& error) {
    log::debug("{}", error.what());  // SQLite has rolled back by itself
  }
}

void Transaction::commit() {
  database_.execute("COMMIT");
  open_ = false;
}

}  // namespace tessera::server
