#include "client/font.hpp"

#define STB_TRUETYPE_IMPLEMENTATION
#define STBTT_STATIC
#include <stb/stb_truetype.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "common/base/error.hpp"

// From font_data.s.in.
extern "C" const unsigned char tessera_font_data[];

namespace tessera::client {

namespace {

const stbtt_fontinfo& font() {
  static const stbtt_fontinfo loaded = [] {
    stbtt_fontinfo out;
    if (stbtt_InitFont(&out, tessera_font_data, 0) == 0)
      throw Error(ErrorKind::failed, "the program's own font cannot be read");
    return out;
  }();
  return loaded;
}

/// Takes one character off the front of UTF-8 (RFC 3629); "?" for a byte that begins none.
int next_character(std::string_view& text) {
  const auto byte = [&](std::size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U;
  };
  const unsigned first = byte(0);
  const std::size_t length = first < 0x80                    ? 1
                             : first >= 0xc2 && first < 0xe0 ? 2
                             : first >= 0xe0 && first < 0xf0 ? 3
                             : first >= 0xf0 && first < 0xf5 ? 4
                                                             : 0;
  unsigned code = length < 2 ? first : first & (0xffU >> (length + 1));
  bool good = length > 0;
  for (std::size_t i = 1; i < length; ++i) {
    good = good && (byte(i) & 0xc0U) == 0x80U;
    code = code << 6 | (byte(i) & 0x3fU);
  }
  text.remove_prefix(good ? length : 1);
  return good && code >= 0x20 ? static_cast<int>(code) : '?';
}

/// Calls `each` with every glyph and where it begins, and gives where the next one would.
template <class Each>
double walk(std::string_view text, double size, const Each& each) {
  const double scale =
      static_cast<double>(stbtt_ScaleForPixelHeight(&font(), static_cast<float>(size)));
  double x = 0;
  int before = 0;
  while (!text.empty()) {
    const int glyph = stbtt_FindGlyphIndex(&font(), next_character(text));
    if (before != 0) x += scale * stbtt_GetGlyphKernAdvance(&font(), before, glyph);
    each(glyph, x);
    int advance = 0, bearing = 0;
    stbtt_GetGlyphHMetrics(&font(), glyph, &advance, &bearing);
    x += scale * advance;
    before = glyph;
  }
  return x;
}

}  // namespace

double text_width(std::string_view text, double size) {
  return walk(text, size, [](int, double) {});
}

double cap_height(double size) {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  stbtt_GetCodepointBox(&font(), 'H', &x0, &y0, &x1, &y1);
  return y1 * static_cast<double>(stbtt_ScaleForPixelHeight(&font(), static_cast<float>(size)));
}

void draw_text(std::string_view text, double x, int baseline, double size,
               const std::function<void(int, int, float)>& pixel) {
  const float scale = stbtt_ScaleForPixelHeight(&font(), static_cast<float>(size));
  std::vector<unsigned char> bitmap;
  walk(text, size, [&](int glyph, double offset) {
    const double left = std::floor(x + offset);
    const auto shift = static_cast<float>(x + offset - left);
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    stbtt_GetGlyphBitmapBoxSubpixel(&font(), glyph, scale, scale, shift, 0, &x0, &y0, &x1, &y1);
    const int width = x1 - x0, height = y1 - y0;
    if (width <= 0 || height <= 0) return;
    bitmap.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0);
    stbtt_MakeGlyphBitmapSubpixel(&font(), bitmap.data(), width, height, width, scale, scale, shift,
                                  0, glyph);
    for (int row = 0; row < height; ++row)
      for (int column = 0; column < width; ++column) {
        const unsigned char covered =
            bitmap[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                   static_cast<std::size_t>(column)];
        if (covered != 0)
          pixel(static_cast<int>(left) + x0 + column, baseline + y0 + row,
                static_cast<float>(covered) / 255);
      }
  });
}

}  // namespace tessera::client
