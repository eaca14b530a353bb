#pragma once
#include <string>
#include <vector>

/// Where everything stands on a contact sheet. Pure.
namespace tessera::client {

/// What a sheet says and how large its pictures are.
struct SheetContent {
  std::string title;
  std::string note;  ///< a line below it; may be empty
  std::string column_name;
  std::vector<std::string> columns;  ///< at least one
  std::string row_name;              ///< empty: there is one row, and it has no label
  std::vector<std::string> rows;     ///< at least one
  std::vector<std::string> blocks;   ///< what stands above each block; at least one, may be empty
  int cell_width = 0, cell_height = 0;  ///< of the box that every picture fits into, pixels
};

enum class TextStyle { title, note, name, value };
/// Pixels, as text_width takes them.
double size_of(TextStyle style);

struct PlacedText {
  std::string text;
  TextStyle style = TextStyle::value;
  double x = 0;      ///< its left end
  int baseline = 0;  ///< y
};

struct SheetBox {
  int x = 0, y = 0;  ///< the upper left corner
};

struct SheetLayout {
  int width = 0, height = 0;
  std::vector<PlacedText> texts;
  std::vector<SheetBox> cells;  ///< row by row, block by block
};

/// Columns and rows lie in a regular grid, as wide and high as their labels need and the pictures
/// are; labels of columns stand centred above them, those of rows to the left, level with the
/// picture's middle. Throws Error{bad_input} for a sheet of more than sheet_pixels_most.
SheetLayout lay_out(const SheetContent& content);

constexpr long long sheet_pixels_most = 100'000'000;

/// The largest size that fits into the box without being larger than it is, in proportion, at least
/// 1×1.
struct PictureSize {
  int width = 0, height = 0;
  bool operator==(const PictureSize&) const = default;
};
PictureSize fitted(PictureSize picture, int width_most);

}  // namespace tessera::client
