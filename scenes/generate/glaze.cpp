#include "scenes/generate/glaze.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "scenes/generate/noise.hpp"

namespace tessera::generate {

namespace {

using Rgb = std::array<double, 3>;  ///< sRGB codes

constexpr std::array<Rgb, 3> clays{{{176, 112, 78}, {196, 170, 138}, {104, 82, 70}}};
/// A glaze, and what it runs into.
constexpr std::array<std::array<Rgb, 2>, 8> glazes{{{{{36, 86, 122}, {120, 178, 186}}},
                                                    {{{122, 158, 128}, {190, 208, 178}}},
                                                    {{{214, 206, 188}, {238, 232, 220}}},
                                                    {{{98, 34, 30}, {168, 62, 40}}},
                                                    {{{30, 34, 44}, {78, 82, 96}}},
                                                    {{{206, 152, 62}, {150, 92, 40}}},
                                                    {{{52, 98, 88}, {28, 54, 62}}},
                                                    {{{188, 128, 130}, {226, 196, 184}}}}};
constexpr Rgb gold{255, 214, 142};

double chance(int kind, int what) { return 0.5 + 0.5 * lattice(kind, what, 9001); }

/// 0 below `from`, 1 above `to`.
double ramp(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

Rgb mixed(const Rgb& a, const Rgb& b, double share) {
  Rgb out;
  for (std::size_t c = 0; c < 3; ++c) out[c] = a[c] + (b[c] - a[c]) * share;
  return out;
}

std::uint8_t code(double value) {
  return static_cast<std::uint8_t>(std::clamp(value + 0.5, 0.0, 255.0));
}

/// What stands at one texel.
struct Spot {
  Rgb color;
  double metallic, roughness;
  double height;  ///< texels
};

class Painter {
 public:
  explicit Painter(int kind)
      : clay_(clays[static_cast<std::size_t>(kind) % 3]),
        glaze_(glazes[static_cast<std::size_t>(kind) % 8]),
        shift_(23.9 * kind),
        line_(0.04 + 0.16 * chance(kind, 0)),
        band_(0.26 + 0.12 * chance(kind, 1)),
        bands_(chance(kind, 2) > 0.45 ? 1 : 0),
        gilded_(chance(kind, 3) > 0.7 ? 1 : 0),
        spots_(chance(kind, 4)),
        gloss_(0.08 + 0.2 * chance(kind, 5)) {}

  /// `around` is cosine and sine, `up` 0…1 along the outline; the lip is about the middle.
  [[nodiscard]] Spot at(const std::array<double, 2>& around, double up) const {
    const auto look = [&](double scale, double shift) {
      return noise({scale * around[0] + shift_, scale * 6 * up + shift, scale * around[1]});
    };
    const double cloud = 0.6 * look(1.9, 0) + 0.35 * look(4.3, 300) + 0.2 * look(9.1, 400);
    const double drip = look(1.7, 50), grain = look(60, 100);
    const double edge = line_ + 0.05 * drip + 0.03 * cloud;
    const double glazed = ramp(edge, edge + 0.012, up);
    const double crackle = 1 - ramp(0, 0.05, std::abs(look(11, 150)));
    const double spot = ramp(0.62 - 0.12 * spots_, 0.72, look(26, 200)) * spots_;
    const double rim = 1 - ramp(0.01, 0.05, std::abs(up - 0.5) + 0.01 * grain);

    Rgb color = mixed(glaze_[0], glaze_[1], ramp(-0.6, 0.6, cloud + 1.8 * (up - 0.35)));
    color = mixed(color, clay_, 0.45 * rim);  // thin over the lip
    color = mixed(color, {46, 34, 28}, 0.75 * spot);
    color = mixed(color, {64, 52, 44}, 0.3 * crackle);
    const double stripe = bands_ * (1 - ramp(0.006, 0.009, std::abs(stripes(up) + 0.002 * drip)));
    color = mixed(color, mixed(glaze_[1], {24, 20, 30}, 0.8), 0.85 * stripe);
    const double gilt = gilded_ * (1 - ramp(0.010, 0.013, std::abs(up - band_ - 0.07)));

    Spot out{mixed(mixed(clay_, {60, 48, 40}, 0.18 + 0.25 * grain), color, glazed), 0, 0, 0};
    out.color = mixed(out.color, gold, gilt);
    out.metallic = gilt;
    out.roughness = 0.85 + (gloss_ + 0.06 * cloud + 0.2 * spot - 0.85) * glazed;
    out.roughness += (0.22 - out.roughness) * gilt;
    out.height = 1.6 * glazed + 0.9 * grain * (1 - 0.85 * glazed) - 0.5 * crackle * glazed +
                 0.5 * stripe + 0.6 * gilt;
    return out;
  }

 private:
  /// Distance to the nearest of three stripes.
  [[nodiscard]] double stripes(double up) const {
    const double at = up - band_;
    return at - 0.028 * std::clamp(std::floor(at / 0.028 + 0.5), -1.0, 1.0);
  }

  Rgb clay_;
  std::array<Rgb, 2> glaze_;
  double shift_, line_, band_, bands_, gilded_, spots_, gloss_;
};

}  // namespace

Glaze glaze(int kind, std::size_t side) {
  const Painter painter(kind);
  Glaze out;
  std::vector<double> heights;
  for (std::size_t y = 0; y < side; ++y)
    for (std::size_t x = 0; x < side; ++x) {
      const auto share = [&](std::size_t i) {
        return (static_cast<double>(i) + 0.5) / static_cast<double>(side);
      };
      const Spot spot = painter.at(on_circle(share(x)), 1 - share(y));
      for (const double c : spot.color) out.base_color.push_back(code(c));
      for (const double c : {255.0, 255 * spot.roughness, 255 * spot.metallic})
        out.metallic_roughness.push_back(code(c));
      heights.push_back(spot.height);
    }
  for (std::size_t y = 0; y < side; ++y)
    for (std::size_t x = 0; x < side; ++x) {
      const auto height = [&](std::size_t column, std::size_t row) {
        return heights[row * side + column % side];
      };
      const double right = 0.5 * (height(x + 1, y) - height(x + side - 1, y));
      const double down =
          0.5 * (height(x, std::min(y + 1, side - 1)) - height(x, y == 0 ? 0 : y - 1));
      for (const double c : unit({-right, down, 1})) out.normal.push_back(code(127.5 + 127.5 * c));
    }
  return out;
}

}  // namespace tessera::generate
