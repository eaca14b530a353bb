#include "worker/render/textures/pyramid.hpp"

#include <immintrin.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cassert>
#include <cstring>
#include <utility>

#include "worker/render/textures/codes.hpp"

namespace tessera::render {
namespace {

using image::TexelFormat;

template <class Value>
Value load(const std::byte* from, int index) {
  Value value;
  std::memcpy(&value, from + static_cast<std::size_t>(index) * sizeof(Value), sizeof(Value));
  return value;
}

/// The channels that there are as R, G, B, A. `color` and `alpha` give a channel's value.
template <class GetColor, class GetAlpha>
Texel expanded(int channels, GetColor color, GetAlpha alpha) {
  if (channels >= 3) return {color(0), color(1), color(2), channels == 4 ? alpha(3) : 1.0F};
  const float gray = color(0);
  return {gray, gray, gray, channels == 2 ? alpha(1) : 1.0F};
}

template <class Code>
Texel decoded(int channels, const std::byte* at, const float* table, const float* alpha_table) {
  return expanded(
      channels, [&](int channel) { return table[load<Code>(at, channel)]; },
      [&](int channel) { return alpha_table[load<Code>(at, channel)]; });
}

float from_half(std::uint16_t half) { return _cvtsh_ss(half); }
std::uint16_t to_half(float value) {
  const __m128i halves = _mm_cvtps_ph(_mm_set_ss(value), _MM_FROUND_TO_NEAREST_INT);
  return static_cast<std::uint16_t>(_mm_cvtsi128_si32(halves));
}

/// Which of `size` texels, from 2·index on, make texel `index` of the next level, and how much of
/// each: every one is used up wholly. Guthe and Heckbert, "Non-Power-of-Two Mipmapping", 2005.
struct Taps {
  int first = 0, count = 1;
  std::array<float, 3> weight{1, 0, 0};

  Taps(int size, int index) {
    if (size == 1) return;
    first = 2 * index;
    if (size % 2 == 0) {
      count = 2;
      weight = {0.5F, 0.5F, 0};
      return;
    }
    count = 3;
    const int half = size / 2;
    const auto whole = static_cast<float>(size);
    weight = {static_cast<float>(half - index) / whole, static_cast<float>(half) / whole,
              static_cast<float>(index + 1) / whole};
  }
};

template <class Body>
void for_rows(int rows, Body body) {
  tbb::parallel_for(tbb::blocked_range<int>(0, rows, 16),
                    [&](const tbb::blocked_range<int>& range) {
                      for (int y = range.begin(); y < range.end(); ++y) body(y);
                    });
}

/// Level by halves. `get(y, room)` gives row `y` of one of width × height, there or elsewhere.
template <class GetRow>
std::vector<Texel> halved(int width, int height, GetRow get) {
  const int to_width = std::max(width / 2, 1), to_height = std::max(height / 2, 1);
  std::vector<Texel> out(static_cast<std::size_t>(to_width) * static_cast<std::size_t>(to_height));
  for_rows(to_height, [&](int y) {
    const Taps rows(height, y);
    std::array<std::vector<Texel>, 3> room;
    std::array<const Texel*, 3> from{};
    for (int j = 0; j < rows.count; ++j) {
      const auto row = static_cast<std::size_t>(j);
      from[row] = get(rows.first + j, room[row]);
    }
    Texel* to = out.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(to_width);
    for (int x = 0; x < to_width; ++x) {
      const Taps columns(width, x);
      Texel sum{};
      for (int j = 0; j < rows.count; ++j) {
        const auto row = static_cast<std::size_t>(j);
        for (int i = 0; i < columns.count; ++i) {
          const Texel& texel = from[row][columns.first + i];
          const float weight = rows.weight[row] * columns.weight[static_cast<std::size_t>(i)];
          for (std::size_t c = 0; c < 4; ++c) sum[c] += texel[c] * weight;
        }
      }
      *to++ = sum;
    }
  });
  return out;
}

}  // namespace

Pyramid::Pyramid(image::Texels&& picture, scene::ColorSpace space, Levels levels)
    : channels_(picture.channels), format_(picture.format) {
  assert(picture.width > 0 && picture.height > 0 && channels_ >= 1 && channels_ <= 4);
  if (image::is_integer(format_)) {
    decode_ = code_table(format_, space).values();
    decode_alpha_ = code_table(format_, scene::ColorSpace::linear).values();
  }
  levels_.push_back({picture.width, picture.height, std::move(picture.bytes)});
  if (levels == Levels::all) add_levels(space);
}

Texel Pyramid::texel(const Level& level, int x, int y) const {
  const std::size_t index = static_cast<std::size_t>(y) * static_cast<std::size_t>(level.width) +
                            static_cast<std::size_t>(x);
  const std::byte* const at =
      level.bytes.data() + index * static_cast<std::size_t>(channels_) * image::bytes_of(format_);
  switch (format_) {
    case TexelFormat::u8:
      return decoded<std::uint8_t>(channels_, at, decode_, decode_alpha_);
    case TexelFormat::u16:
      return decoded<std::uint16_t>(channels_, at, decode_, decode_alpha_);
    case TexelFormat::f16: {
      const auto value = [&](int channel) { return from_half(load<std::uint16_t>(at, channel)); };
      return expanded(channels_, value, value);
    }
    case TexelFormat::f32:
      break;
  }
  const auto value = [&](int channel) { return load<float>(at, channel); };
  return expanded(channels_, value, value);
}

std::size_t Pyramid::bytes() const {
  std::size_t sum = 0;
  for (const Level& level : levels_) sum += level.bytes.size();
  return sum;
}

void Pyramid::decode_row(int y, Texel* out) const {
  const Level& level = levels_[0];
  for (int x = 0; x < level.width; ++x) out[x] = texel(level, x, y);
}

void Pyramid::add_levels(scene::ColorSpace space) {
  int width = levels_[0].width, height = levels_[0].height;
  // The next level comes from the last one's floats, so that rounding does not add up.
  std::vector<Texel> last;
  while (width > 1 || height > 1) {
    last = halved(width, height, [&](int y, std::vector<Texel>& room) -> const Texel* {
      if (!last.empty())
        return last.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
      room.resize(static_cast<std::size_t>(width));
      decode_row(y, room.data());
      return room.data();
    });
    width = std::max(width / 2, 1);
    height = std::max(height / 2, 1);
    levels_.push_back(encode(width, height, last, space));
  }
}

Pyramid::Level Pyramid::encode(int width, int height, const std::vector<Texel>& texels,
                               scene::ColorSpace space) const {
  const auto channels = static_cast<std::size_t>(channels_);
  const std::size_t size = image::bytes_of(format_);
  Level out{width, height, std::vector<std::byte>(texels.size() * channels * size)};
  const bool integer = image::is_integer(format_);
  const CodeTable* const colors = integer ? &code_table(format_, space) : nullptr;
  const CodeTable* const alphas =
      integer ? &code_table(format_, scene::ColorSpace::linear) : nullptr;
  for_rows(height, [&](int y) {
    const std::size_t first = static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
    for (std::size_t i = first; i < first + static_cast<std::size_t>(width); ++i) {
      for (std::size_t c = 0; c < channels; ++c) {
        const bool alpha = c == 3 || (channels == 2 && c == 1);
        const float value = texels[i][alpha ? 3 : c];
        std::byte* const to = out.bytes.data() + (i * channels + c) * size;
        if (format_ == TexelFormat::f32) {
          std::memcpy(to, &value, size);
          continue;
        }
        const std::uint16_t code = format_ == TexelFormat::f16
                                       ? to_half(value)
                                       : (alpha ? alphas : colors)->nearest(value);
        if (size == 1) {
          *to = static_cast<std::byte>(code);
        } else {
          std::memcpy(to, &code, size);
        }
      }
    }
  });
  return out;
}

}  // namespace tessera::render
