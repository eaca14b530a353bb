#include "client/sheet.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "client/font.hpp"

namespace tessera::client {

namespace {

using Color = std::array<double, 3>;  // as sRGB encodes it, 0…1
constexpr Color paper{1, 1, 1};
constexpr Color dark{0.11, 0.11, 0.12};
constexpr Color grey{0.42, 0.42, 0.45};
constexpr Color empty{0.93, 0.93, 0.94};  // of a cell that has no picture

Color color_of(TextStyle style) {
  return style == TextStyle::title || style == TextStyle::value ? dark : grey;
}

/// IEC 61966-2-1.
float linear(double encoded) {
  return static_cast<float>(encoded <= 0.04045 ? encoded / 12.92
                                               : std::pow((encoded + 0.055) / 1.055, 2.4));
}

/// One dimension of scaled_down: `count` values `stride` apart become `to` of them.
void scale_line(const float* from, std::size_t count, std::size_t stride, float* to,
                std::size_t to_count, std::size_t to_stride) {
  const double step = static_cast<double>(count) / static_cast<double>(to_count);
  for (std::size_t i = 0; i < to_count; ++i) {
    const double begin = static_cast<double>(i) * step;
    const double end = std::min(begin + step, static_cast<double>(count));
    double sum = 0;
    for (auto at = static_cast<std::size_t>(begin); at < count && static_cast<double>(at) < end;
         ++at) {
      const double covered =
          std::min(end, static_cast<double>(at + 1)) - std::max(begin, static_cast<double>(at));
      sum += covered * static_cast<double>(from[at * stride]);
    }
    to[i * to_stride] = static_cast<float>(sum / (end - begin));
  }
}

}  // namespace

std::vector<float> scaled_down(std::span<const float> plane, PictureSize from, PictureSize to) {
  const auto width = static_cast<std::size_t>(from.width);
  const auto height = static_cast<std::size_t>(from.height);
  const auto to_width = static_cast<std::size_t>(to.width);
  const auto to_height = static_cast<std::size_t>(to.height);
  std::vector<float> rows(to_width * height), out(to_width * to_height);
  for (std::size_t y = 0; y < height; ++y)
    scale_line(plane.data() + y * width, width, 1, rows.data() + y * to_width, to_width, 1);
  for (std::size_t x = 0; x < to_width; ++x)
    scale_line(rows.data() + x, height, to_width, out.data() + x, to_height, to_width);
  return out;
}

Sheet::Sheet(SheetLayout layout, int cell_width, int cell_height)
    : layout_(std::move(layout)),
      cell_width_(cell_width),
      cell_height_(cell_height),
      planes_(
          3 * static_cast<std::size_t>(layout_.width) * static_cast<std::size_t>(layout_.height),
          linear(paper[0])) {
  for (const PlacedText& text : layout_.texts) draw(text, paper);
}

void Sheet::dot(std::size_t channel, int x, int y, float value) {
  if (x < 0 || y < 0 || x >= layout_.width || y >= layout_.height) return;
  const auto width = static_cast<std::size_t>(layout_.width);
  const auto height = static_cast<std::size_t>(layout_.height);
  planes_[(channel * height + static_cast<std::size_t>(y)) * width + static_cast<std::size_t>(x)] =
      value;
}

void Sheet::draw(const PlacedText& text, const Color& ground) {
  const Color color = color_of(text.style);
  draw_text(text.text, text.x, text.baseline, size_of(text.style),
            [&](int x, int y, float coverage) {
              // Mixed as displays mix: mixed in light, dark letters look thin.
              const auto part = static_cast<double>(coverage);
              for (std::size_t c = 0; c < 3; ++c)
                dot(c, x, y, linear(ground[c] + part * (color[c] - ground[c])));
            });
}

void Sheet::place(std::size_t cell, const image::ExrImage& picture, int width_most,
                  const Look& look) {
  const PictureSize from{picture.width, picture.height};
  const PictureSize to = fitted(from, width_most);
  const SheetBox& box = layout_.cells.at(cell);
  const int left = box.x + (cell_width_ - to.width) / 2;
  const int top = box.y + (cell_height_ - to.height) / 2;
  const auto scale = static_cast<float>(std::exp2(look.exposure));
  constexpr std::array<const char*, 3> names{"R", "G", "B"};
  for (std::size_t c = 0; c < 3; ++c) {
    const std::span<const float> plane = picture.plane(names[c]);
    std::vector<float> shown(plane.begin(), plane.end());
    // What a PNG cuts off does not shine into its neighbours either.
    for (float& value : shown)
      value = std::clamp(image::seen(look.view, value * scale), 0.0F, 1.0F);
    if (to != from) shown = scaled_down(shown, from, to);
    for (int y = 0; y < to.height; ++y)
      for (int x = 0; x < to.width; ++x)
        dot(c, left + x, top + y,
            shown[static_cast<std::size_t>(y) * static_cast<std::size_t>(to.width) +
                  static_cast<std::size_t>(x)]);
  }
}

void Sheet::place_words(std::size_t cell, const std::string& words) {
  const SheetBox& box = layout_.cells.at(cell);
  for (std::size_t c = 0; c < 3; ++c)
    for (int y = 0; y < cell_height_; ++y)
      for (int x = 0; x < cell_width_; ++x) dot(c, box.x + x, box.y + y, linear(empty[c]));
  const double size = size_of(TextStyle::note);
  draw({words, TextStyle::note, std::round(box.x + (cell_width_ - text_width(words, size)) / 2),
        box.y + static_cast<int>(std::lround((cell_height_ + cap_height(size)) / 2))},
       empty);
}

std::vector<std::byte> Sheet::png() const {
  return image::encode_png(layout_.width, layout_.height, planes_);
}

}  // namespace tessera::client
