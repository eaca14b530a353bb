#include "client/sheet.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "client/font.hpp"
#include "tests/unit/client/support.hpp"

namespace tessera::client {
namespace {

SheetContent content() {
  return {.title = "Ball",
          .note = "40 × 30",
          .column_name = "samples",
          .columns = {"1", "4", "16"},
          .row_name = "light_samples",
          .rows = {"1", "2"},
          .blocks = {""},
          .cell_width = 100,
          .cell_height = 60};
}

const PlacedText& text_at(const SheetLayout& layout, const std::string& text, int nth = 0) {
  for (const PlacedText& placed : layout.texts)
    if (placed.text == text && nth-- == 0) return placed;
  throw std::runtime_error("no text " + text);
}

double middle_of(const PlacedText& text) {
  return text.x + text_width(text.text, size_of(text.style)) / 2;
}

TEST(SheetLayout, cells_lie_in_a_grid_without_overlap_within_the_sheet) {
  SheetContent asked = content();
  asked.blocks = {"seed = 1", "seed = 2"};
  const SheetLayout layout = lay_out(asked);
  ASSERT_EQ(layout.cells.size(), 12U);
  for (std::size_t i = 0; i < layout.cells.size(); ++i) {
    const SheetBox& a = layout.cells[i];
    EXPECT_GE(a.x, 0);
    EXPECT_LE(a.x + 100, layout.width);
    EXPECT_LE(a.y + 60, layout.height);
    EXPECT_EQ(a.x, layout.cells[i % 3].x) << "columns are straight";
    EXPECT_EQ(a.y, layout.cells[i / 3 * 3].y) << "rows are straight";
    for (std::size_t j = 0; j < i; ++j) {
      const SheetBox& b = layout.cells[j];
      EXPECT_TRUE(std::abs(a.x - b.x) >= 100 || std::abs(a.y - b.y) >= 60) << i << " on " << j;
    }
  }
}

TEST(SheetLayout, a_label_stands_in_the_middle_of_its_column_or_row) {
  const SheetLayout layout = lay_out(content());
  EXPECT_NEAR(middle_of(text_at(layout, "16")), layout.cells[2].x + 50, 1);
  const PlacedText row = text_at(layout, "2");
  EXPECT_NEAR(row.baseline - cap_height(size_of(row.style)) / 2, layout.cells[3].y + 30, 1);
  EXPECT_LT(row.x, layout.cells[3].x);
  EXPECT_LT(text_at(layout, "16").baseline, layout.cells[2].y);
  EXPECT_NEAR(middle_of(text_at(layout, "samples")), layout.cells[1].x + 50, 2);
}

TEST(SheetLayout, texts_do_not_overlap_and_lie_within_the_sheet_however_long_they_are) {
  SheetContent asked = content();
  asked.columns = {"[0.25,0.25,0.25]", "[0.123456,0.123456,0.123456]", "1"};
  asked.rows = {"a rather long word for a row", "2"};
  asked.note = std::string(200, 'n');
  asked.blocks = {"materials.white.reflectance = 1", "materials.white.reflectance = 2"};
  asked.cell_width = asked.cell_height = 5;
  const SheetLayout layout = lay_out(asked);
  for (std::size_t i = 0; i < layout.texts.size(); ++i) {
    const PlacedText& a = layout.texts[i];
    const double size = size_of(a.style);
    EXPECT_GE(a.x, 0) << a.text;
    EXPECT_LE(a.x + text_width(a.text, size), layout.width) << a.text;
    EXPECT_GE(a.baseline - size, -1) << a.text;
    EXPECT_LE(a.baseline, layout.height) << a.text;
    for (std::size_t j = 0; j < i; ++j) {
      const PlacedText& b = layout.texts[j];
      const bool apart = a.x >= b.x + text_width(b.text, size_of(b.style)) ||
                         b.x >= a.x + text_width(a.text, size) ||
                         a.baseline - cap_height(size) >= b.baseline ||
                         b.baseline - cap_height(size_of(b.style)) >= a.baseline;
      EXPECT_TRUE(apart) << a.text << " on " << b.text;
    }
  }
}

TEST(SheetLayout, a_sheet_beyond_the_limit_is_refused_before_anything_is_made) {
  SheetContent asked = content();
  asked.columns.assign(1000, "1");
  asked.cell_width = asked.cell_height = 65536;
  const Error error = error_of([&] { (void)lay_out(asked); });
  EXPECT_EQ(error.kind(), ErrorKind::bad_input);
  EXPECT_EQ(error.place().key, "--cell-width");
}

TEST(Fitted, a_picture_shrinks_in_proportion_and_never_grows) {
  EXPECT_EQ(fitted({1920, 1080}, 480), (PictureSize{480, 270}));
  EXPECT_EQ(fitted({100, 50}, 480), (PictureSize{100, 50}));
  EXPECT_EQ(fitted({10000, 3}, 100), (PictureSize{100, 1}));
}

TEST(ScaledDown, each_value_is_the_mean_over_its_area) {
  EXPECT_EQ(scaled_down(std::vector<float>{1, 2, 3, 4, 5, 6, 7, 8}, {4, 2}, {2, 1}),
            (std::vector<float>{3.5F, 5.5F}));
  // 3 to 2: each new value covers one and a half.
  const std::vector<float> two = scaled_down(std::vector<float>{0, 3, 9}, {3, 1}, {2, 1});
  EXPECT_FLOAT_EQ(two[0], 1);
  EXPECT_FLOAT_EQ(two[1], 7);
  const std::vector<float> flat =
      scaled_down(std::vector<float>(97 * 53, 0.25F), {97, 53}, {31, 17});
  for (const float value : flat) EXPECT_FLOAT_EQ(value, 0.25F);
}

TEST(Font, wider_text_is_wider_and_covers_pixels_above_its_baseline) {
  EXPECT_GT(text_width("samples", 20), text_width("sample", 20));
  EXPECT_NEAR(text_width("samples", 40), 2 * text_width("samples", 20), 0.01);
  EXPECT_EQ(text_width("", 20), 0);
  double sum = 0;
  int lowest = 0, highest = 0;
  draw_text("H", 10, 100, 20, [&](int x, int y, float coverage) {
    EXPECT_GE(x, 10);
    EXPECT_LT(y, 101);
    sum += static_cast<double>(coverage);
    lowest = std::max(lowest, y);
    highest = highest == 0 ? y : std::min(highest, y);
  });
  EXPECT_GT(sum, 10);
  EXPECT_NEAR(lowest - highest + 1, cap_height(20), 1.5);
}

TEST(Font, characters_beyond_ascii_are_one_glyph_and_broken_ones_a_question_mark) {
  EXPECT_EQ(text_width("×", 20), text_width("\xc3\x97", 20));
  EXPECT_LT(text_width("×", 20), text_width("Ã\x97", 20));
  EXPECT_EQ(text_width("\xff", 20), text_width("?", 20));
  EXPECT_EQ(text_width("\xe2\x82", 20), text_width("??", 20));
}

image::ExrImage picture(int width, int height, float value) {
  image::ExrImage out;
  out.width = width;
  out.height = height;
  out.channels = {"B", "G", "R"};
  out.values.assign(3 * static_cast<std::size_t>(width * height), value);
  return out;
}

TEST(Sheet, a_picture_changes_its_own_cell_alone) {
  const SheetLayout layout = lay_out(content());
  Sheet bare(layout, 100, 60), one(layout, 100, 60), dark(layout, 100, 60);
  one.place(4, picture(100, 60, 0.5F), 512, {});
  dark.place(4, picture(200, 120, 1), 100, {.exposure = -1});
  EXPECT_NE(one.png(), bare.png());
  EXPECT_EQ(one.png(), dark.png()) << "one stop down is half, and scaling keeps a plain colour";
}

}  // namespace
}  // namespace tessera::client
