#include "tests/peer/likeness.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <string>

#include "common/base/error.hpp"

namespace tessera::peer {

namespace {

using image::ExrImage;

/// A picture's R, G, B.
struct Planes {
  int width = 0, height = 0;
  std::array<std::span<const float>, 3> rgb;

  explicit Planes(const ExrImage& image)
      : width(image.width),
        height(image.height),
        rgb{image.plane("R"), image.plane("G"), image.plane("B")} {}

  [[nodiscard]] std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  }
  [[nodiscard]] double luminance(std::size_t pixel) const {
    return 0.2126 * rgb[0][pixel] + 0.7152 * rgb[1][pixel] + 0.0722 * rgb[2][pixel];
  }
  [[nodiscard]] double mean(std::size_t channel) const {
    double sum = 0;
    for (const float value : rgb[channel]) sum += value;
    return sum / static_cast<double>(rgb[channel].size());
  }
  [[nodiscard]] double mean_luminance() const {
    return 0.2126 * mean(0) + 0.7152 * mean(1) + 0.0722 * mean(2);
  }
};

double rel_mse(const Planes& a, const Planes& b) {
  const double mean = b.mean_luminance(), floor = 0.01 * mean * mean;
  double sum = 0;
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t i = 0; i < a.rgb[c].size(); ++i) {
      const double x = a.rgb[c][i], y = b.rgb[c][i];
      const double below = y * y + floor;
      sum += below > 0 ? (x - y) * (x - y) / below : 0;
    }
  return sum / (3.0 * static_cast<double>(a.rgb[0].size()));
}

Blocks compare_blocks(const Planes& a, const Planes& b) {
  Blocks out;
  std::vector<double> all;
  const double floor = 0.01 * b.mean_luminance();
  for (int y = 0; y < a.height; y += block_side)
    for (int x = 0; x < a.width; x += block_side) {
      double of_a = 0, of_b = 0, count = 0;
      for (int v = y; v < std::min(y + block_side, a.height); ++v)
        for (int u = x; u < std::min(x + block_side, a.width); ++u) {
          of_a += a.luminance(a.at(u, v));
          of_b += b.luminance(b.at(u, v));
          ++count;
        }
      const double below = of_b / count + floor;
      all.push_back(below > 0 ? std::abs(of_a - of_b) / count / below : 0);
      if (all.back() > out.most) {
        out.most = all.back();
        out.x = x;
        out.y = y;
      }
    }
  std::nth_element(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2),
                   all.end());
  out.median = all[all.size() / 2];
  return out;
}

/// Luminance of which edges of dark and bright things weigh alike.
std::vector<double> toned(const Planes& planes) {
  const double mean = std::max(planes.mean_luminance(), 1e-30);
  std::vector<double> out(planes.rgb[0].size());
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = std::log1p(std::max(planes.luminance(i), 0.0) / mean);
  return out;
}

/// Solves a symmetric system of three; zeros if it has no one solution.
std::array<double, 3> solve(const std::array<std::array<double, 3>, 3>& m,
                            const std::array<double, 3>& v) {
  const auto determinant = [](const auto& a, const auto& b, const auto& c) {
    return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
           a[2] * (b[0] * c[1] - b[1] * c[0]);
  };
  const double whole = determinant(m[0], m[1], m[2]);
  if (!(std::abs(whole) > 1e-12)) return {};
  return {determinant(v, m[1], m[2]) / whole, determinant(m[0], v, m[2]) / whole,
          determinant(m[0], m[1], v) / whole};
}

/// One step of Lucas and Kanade's, over the whole picture: the move that explains the difference
/// to first order, in the least squares.
Framing compare_framing(const Planes& a, const Planes& b) {
  const std::vector<double> first = toned(a), second = toned(b);
  std::array<std::array<double, 3>, 3> m{};
  std::array<double, 3> v{};
  for (int y = 1; y + 1 < a.height; ++y)
    for (int x = 1; x + 1 < a.width; ++x) {
      const auto slope = [&](const std::vector<double>& of) {
        return std::array<double, 2>{0.5 * (of[a.at(x + 1, y)] - of[a.at(x - 1, y)]),
                                     0.5 * (of[a.at(x, y + 1)] - of[a.at(x, y - 1)])};
      };
      const auto one = slope(first), other = slope(second);
      const double along_x = 0.5 * (one[0] + other[0]), along_y = 0.5 * (one[1] + other[1]);
      const std::array<double, 3> by{
          along_x, along_y,
          along_x * (x + 0.5 - a.width / 2.0) + along_y * (y + 0.5 - a.height / 2.0)};
      const double off = second[a.at(x, y)] - first[a.at(x, y)];
      for (std::size_t i = 0; i < 3; ++i) {
        v[i] += by[i] * off;
        for (std::size_t k = 0; k < 3; ++k) m[i][k] += by[i] * by[k];
      }
    }
  const std::array<double, 3> found = solve(m, v);
  return {.right = found[0], .down = found[1], .larger = found[2]};
}

void require_alike(const ExrImage& first, const ExrImage& second) {
  if (first.width == second.width && first.height == second.height) return;
  throw Error(ErrorKind::bad_input,
              fmt::format("one picture is {}x{}, the other {}x{}", first.width, first.height,
                          second.width, second.height));
}

}  // namespace

Likeness compare(const ExrImage& first, const ExrImage& second) {
  require_alike(first, second);
  const Planes a(first), b(second);
  Likeness out;
  for (std::size_t c = 0; c < 3; ++c) {
    out.first[c] = a.mean(c);
    out.second[c] = b.mean(c);
  }
  out.rel_mse = rel_mse(a, b);
  out.framing = compare_framing(a, b);
  out.blocks = compare_blocks(a, b);
  return out;
}

std::vector<std::byte> side_by_side(const ExrImage& first, const ExrImage& second) {
  require_alike(first, second);
  const Planes a(first), b(second);
  const int gap = 4, width = 3 * a.width + 2 * gap;
  const std::size_t step = static_cast<std::size_t>(a.width) + gap;
  const auto plane = static_cast<std::size_t>(width) * static_cast<std::size_t>(a.height);
  std::vector<float> out(3 * plane, 1.0F);
  const double mean = b.mean_luminance(), exposure = mean > 0 ? 0.25 / mean : 1;
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x) {
      const std::size_t from = a.at(x, y);
      const std::size_t to = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                             static_cast<std::size_t>(x);
      for (std::size_t c = 0; c < 3; ++c) {
        out[c * plane + to] = static_cast<float>(exposure * a.rgb[c][from]);
        out[c * plane + to + step] = static_cast<float>(exposure * b.rgb[c][from]);
      }
      const double l = a.luminance(from), r = b.luminance(from), sum = l + r + 0.02 * mean;
      const double by = sum > 0 ? std::clamp(2 * (l - r) / sum, -1.0, 1.0) : 0;
      const std::array<double, 3> shown{1 + std::min(by, 0.0), 1 - std::abs(by),
                                        1 - std::max(by, 0.0)};
      for (std::size_t c = 0; c < 3; ++c)
        out[c * plane + to + 2 * step] = static_cast<float>(shown[c]);
    }
  return image::encode_png(width, a.height, out);
}

}  // namespace tessera::peer
