#include "client/table.hpp"

#include <algorithm>

namespace tessera::client {

namespace {

/// Characters of UTF-8: all bytes but those that go on.
std::size_t length_of(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xc0U) != 0x80U;
  }));
}

}  // namespace

std::string text_of(const Table& table) {
  std::vector<std::string> titles;
  std::vector<std::size_t> widths;
  for (const Table::Column& column : table.columns) {
    titles.push_back(column.title);
    widths.push_back(length_of(column.title));
  }
  for (const auto& row : table.rows)
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], length_of(row[i]));
  std::string out;
  const auto add = [&](const std::vector<std::string>& cells) {
    std::string line;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const std::string blanks(widths[i] - length_of(cells[i]), ' ');
      if (i > 0) line += "  ";
      line += table.columns[i].align == Table::Align::right ? blanks + cells[i] : cells[i] + blanks;
    }
    line.erase(line.find_last_not_of(' ') + 1);
    out += line + "\n";
  };
  add(titles);
  for (const auto& row : table.rows) add(row);
  return out;
}

}  // namespace tessera::client
