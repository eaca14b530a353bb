#include "server/film/noise.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace tessera::server {
namespace {

constexpr double left_out = 0.01;   ///< of the pixels, the noisiest
constexpr double background = 0.1;  ///< of the film's mean light, added to each pixel's

struct Pixel {
  double error, light;
};
static_assert(noise_bytes == sizeof(Pixel) + sizeof(double));

/// False if its pixels have too few samples to tell.
bool append(const FilmTile* tile, std::vector<Pixel>& out) {
  if (!tile) return false;
  const auto n = static_cast<double>(tile->samples[static_cast<std::size_t>(image::Group::beauty)]);
  if (n < 2) return false;
  const std::size_t pixels = tile->pixels();
  for (std::size_t i = 0; i < pixels; ++i) {
    double light = 0, variance = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      light += tile->sums[(image::R + c) * pixels + i] / n;
      variance += tile->sums[(image::M2_R + c) * pixels + i] / (n * (n - 1));
    }
    out.push_back({std::sqrt(variance / 3), light / 3});
  }
  return true;
}

}  // namespace

double noise_of(const FilmSnapshot& film) {
  std::vector<Pixel> pixels;
  pixels.reserve(static_cast<std::size_t>(film.grid.window().pixels()));
  for (const auto& tile : film.tiles)
    if (!append(tile.get(), pixels)) return std::numeric_limits<double>::infinity();
  double light = 0;
  for (const Pixel& pixel : pixels) light += pixel.light;
  const double floor = background * light / static_cast<double>(pixels.size());
  std::vector<double> relative;
  relative.reserve(pixels.size());
  for (const Pixel& pixel : pixels) {
    const double against = pixel.light + floor;
    relative.push_back(pixel.error > 0 && against > 0 ? pixel.error / against : 0);
  }
  const auto kept =
      relative.size() - static_cast<std::size_t>(left_out * static_cast<double>(relative.size()));
  // In order, so that equal films give equal bits whatever the sort does with what is left.
  std::sort(relative.begin(), relative.end());
  double sum = 0;
  for (std::size_t i = 0; i < kept; ++i) sum += relative[i];
  return sum / static_cast<double>(kept);
}

}  // namespace tessera::server
