#include "client/sheet_layout.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "client/font.hpp"
#include "common/base/error.hpp"

namespace tessera::client {

namespace {

constexpr int margin = 24;
constexpr int gap = 10;          ///< between pictures, and between a label and its picture
constexpr int line_gap = 8;      ///< between lines of text
constexpr int heading_gap = 22;  ///< below the title
constexpr int block_gap = 30;    ///< between blocks
constexpr double line_height = 1.2;

int line(TextStyle style) { return static_cast<int>(std::lround(line_height * size_of(style))); }

int widest(const std::vector<std::string>& texts, TextStyle style) {
  double out = 0;
  for (const std::string& text : texts) out = std::max(out, text_width(text, size_of(style)));
  return static_cast<int>(std::ceil(out));
}

/// Places one thing after the other, from the top down.
class Placer {
 public:
  explicit Placer(const SheetContent& content)
      : content_(content),
        gutter_(content.row_name.empty()
                    ? 0
                    : gap + std::max(widest(content.rows, TextStyle::value),
                                     widest({content.row_name}, TextStyle::name))),
        column_pitch_(gap +
                      std::max(content.cell_width, widest(content.columns, TextStyle::value))),
        row_pitch_(gap + std::max(content.cell_height, line(TextStyle::value))),
        grid_width_(std::max(static_cast<int>(content.columns.size()) * column_pitch_ - gap,
                             widest({content.column_name}, TextStyle::name))) {}

  SheetLayout place() {
    heading();
    for (std::size_t i = 0; i < content_.blocks.size(); ++i) {
      if (i > 0) y_ += block_gap - gap;
      block(content_.blocks[i]);
    }
    out_.height = y_ - gap + margin;
    const int words = std::max({widest({content_.title}, TextStyle::title),
                                widest({content_.note}, TextStyle::note),
                                widest(content_.blocks, TextStyle::name)});
    out_.width = 2 * margin + std::max(gutter_ + grid_width_, words);
    return std::move(out_);
  }

 private:
  void text(const std::string& text, TextStyle style, double x, int baseline) {
    if (!text.empty()) out_.texts.push_back({text, style, x, baseline});
  }
  /// `at` is the middle.
  void centred(const std::string& words, TextStyle style, double at, int baseline) {
    text(words, style, std::round(at - text_width(words, size_of(style)) / 2), baseline);
  }
  /// `at` is the right end.
  void flush_right(const std::string& words, TextStyle style, double at, int baseline) {
    text(words, style, std::round(at - text_width(words, size_of(style))), baseline);
  }
  /// A line of its own; gives its baseline.
  int next_line(TextStyle style) {
    const int baseline = y_ + static_cast<int>(std::lround(cap_height(size_of(style))));
    y_ = baseline + line_gap;
    return baseline;
  }

  void heading() {
    y_ = margin;
    text(content_.title, TextStyle::title, margin, next_line(TextStyle::title));
    if (!content_.note.empty()) {
      y_ += line_gap / 2;
      text(content_.note, TextStyle::note, margin, next_line(TextStyle::note));
    }
    y_ += heading_gap - line_gap;
  }

  void block(const std::string& words) {
    if (!words.empty()) {
      text(words, TextStyle::name, margin, next_line(TextStyle::name));
      y_ += line_gap;
    }
    const int left = margin + gutter_;
    centred(content_.column_name, TextStyle::name, left + grid_width_ / 2.0,
            next_line(TextStyle::name));
    y_ += 2;
    const int labels = next_line(TextStyle::value);
    y_ += gap - line_gap;
    flush_right(content_.row_name, TextStyle::name, left - gap, labels);
    const auto middle = [&](std::size_t column) {
      return left + static_cast<int>(column) * column_pitch_ + (column_pitch_ - gap) / 2.0;
    };
    for (std::size_t column = 0; column < content_.columns.size(); ++column)
      centred(content_.columns[column], TextStyle::value, middle(column), labels);
    const double capital = cap_height(size_of(TextStyle::value));
    for (const std::string& row : content_.rows) {
      const int height = row_pitch_ - gap;
      if (!content_.row_name.empty())
        flush_right(row, TextStyle::value, left - gap,
                    y_ + static_cast<int>(std::lround((height + capital) / 2)));
      for (std::size_t column = 0; column < content_.columns.size(); ++column)
        out_.cells.push_back(
            {static_cast<int>(std::floor(middle(column) - content_.cell_width / 2.0)),
             y_ + (height - content_.cell_height) / 2});
      y_ += row_pitch_;
    }
  }

  const SheetContent& content_;
  int gutter_, column_pitch_, row_pitch_, grid_width_;
  int y_ = 0;
  SheetLayout out_;
};

}  // namespace

double size_of(TextStyle style) {
  switch (style) {
    case TextStyle::title:
      return 26;
    case TextStyle::note:
      return 15;
    case TextStyle::name:
      return 17;
    case TextStyle::value:
      return 19;
  }
  return 0;
}

SheetLayout lay_out(const SheetContent& content) {
  // Before anything is placed: 32-bit numbers hold what a reasonable sheet has.
  const auto columns = static_cast<long long>(content.columns.size());
  const auto rows =
      static_cast<long long>(content.rows.size()) * static_cast<long long>(content.blocks.size());
  const long long least =
      columns * rows * (content.cell_width + gap) * static_cast<long long>(content.cell_height);
  SheetLayout out;
  if (least <= sheet_pixels_most) out = Placer(content).place();
  const long long pixels = std::max(least, static_cast<long long>(out.width) * out.height);
  if (pixels > sheet_pixels_most)
    throw Error(ErrorKind::bad_input,
                fmt::format("a sheet of {} by {} pictures of {}x{} has more than the {} million "
                            "pixels that a sheet may have; make the pictures on it smaller",
                            columns, rows, content.cell_width, content.cell_height,
                            sheet_pixels_most / 1'000'000),
                {.file = {}, .key = "--cell-width"});
  return out;
}

PictureSize fitted(PictureSize picture, int width_most) {
  if (picture.width <= width_most) return picture;
  const double scale = static_cast<double>(width_most) / picture.width;
  return {width_most, std::max(1, static_cast<int>(std::lround(picture.height * scale)))};
}

}  // namespace tessera::client
