#pragma once
#include <functional>
#include <string_view>

/// Text as pixels: DejaVu Sans, which is part of the program, drawn by stb_truetype.
namespace tessera::client {

/// Pixels from the text's first to its last, at `size` pixels from the top of the highest letters
/// to the bottom of the lowest. `text` is UTF-8; what is not counts as "?".
double text_width(std::string_view text, double size);

/// The height of a capital letter above the baseline, pixels.
double cap_height(double size);

/// Calls `pixel` with each pixel that the text covers and how much of it, 0…1. The text's origin is
/// (x, baseline); y grows downwards.
void draw_text(std::string_view text, double x, int baseline, double size,
               const std::function<void(int x, int y, float coverage)>& pixel);

}  // namespace tessera::client
