#pragma once
#include <string>
#include <vector>

namespace tessera::client {

/// Text in columns, as `jobs` and `workers` answer.
struct Table {
  enum class Align { left, right };
  struct Column {
    std::string title;
    Align align = Align::left;
  };
  std::vector<Column> columns;
  std::vector<std::vector<std::string>> rows;  ///< of as many cells as there are columns
};

/// One line for the titles and one a row; each column as wide as its widest cell, nothing behind
/// the last.
std::string text_of(const Table& table);

}  // namespace tessera::client
