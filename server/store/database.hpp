#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "common/base/error.hpp"

struct sqlite3;
struct sqlite3_stmt;

/// SQLite, with errors as Error and handles that close themselves. The only place that includes it.
namespace tessera::server {

/// An Error that remembers SQLite's code.
class DatabaseError : public Error {
 public:
  DatabaseError(ErrorKind kind, std::string message, int code)
      : Error(kind, std::move(message)), code_(code) {}
  /// The disk was full before anything of the transaction was written as committed.
  [[nodiscard]] bool disk_full() const;

 private:
  int code_;
};

class Statement {
 public:
  Statement(sqlite3* database, std::string_view sql);

  /// Binds ?1, ?2, … and runs to the first row; true if there is one. A statement may be run again
  /// and again.
  template <class... Args>
  bool run(const Args&... args) {
    reset();
    int index = 0;
    (bind(++index, args), ...);
    return step();
  }
  /// On to the next row; false (and the statement is reset) after the last.
  bool step();
  void reset();

  [[nodiscard]] std::int64_t integer(int column) const;
  [[nodiscard]] double number(int column) const;
  [[nodiscard]] std::string text(int column) const;

 private:
  void bind(int index, std::int64_t value);
  void bind(int index, std::uint64_t value) { bind(index, static_cast<std::int64_t>(value)); }
  void bind(int index, std::int32_t value) { bind(index, std::int64_t{value}); }
  void bind(int index, std::uint32_t value) { bind(index, std::int64_t{value}); }
  void bind(int index, double value);
  void bind(int index, const std::string& value);
  void check(int code) const;

  struct Closer {
    void operator()(sqlite3_stmt* statement) const;
  };
  sqlite3* database_;
  std::unique_ptr<sqlite3_stmt, Closer> statement_;
};

class Database {
 public:
  enum class Mode { read_write, read_only };
  /// `vfs` as Disk::sqlite_vfs() says. Throws Error{failed} that names the file.
  Database(const std::filesystem::path& file, Mode mode, const char* vfs = nullptr);

  void execute(const std::string& sql);
  [[nodiscard]] Statement prepare(std::string_view sql);
  /// The first column of the only row.
  std::int64_t integer(std::string_view sql);
  [[nodiscard]] std::int64_t last_row() const;

 private:
  struct Closer {
    void operator()(sqlite3* database) const;
  };
  std::unique_ptr<sqlite3, Closer> database_;
};

/// Everything between is one transaction, rolled back unless committed.
class Transaction {
 public:
  explicit Transaction(Database& database);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void commit();

 private:
  Database& database_;
  bool open_ = true;
};

}  // namespace tessera::server
