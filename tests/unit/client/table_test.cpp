#include "client/table.hpp"

#include <gtest/gtest.h>

namespace tessera::client {
namespace {

TEST(Table, columns_are_as_wide_as_their_widest_cell) {
  const Table table{{{"JOB", Table::Align::right}, {"STATE"}, {"NAME"}},
                    {{"7", "rendering", "Ball"}, {"12345", "done", ""}, {"8", "är", "x"}}};
  EXPECT_EQ(text_of(table),
            "  JOB  STATE      NAME\n"
            "    7  rendering  Ball\n"
            "12345  done\n"
            "    8  är         x\n");
}

TEST(Table, without_rows_there_are_titles) {
  EXPECT_EQ(text_of({{{"A"}, {"B", Table::Align::right}}, {}}), "A  B\n");
}

}  // namespace
}  // namespace tessera::client
