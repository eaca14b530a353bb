#include "scenes/report/measure/statistics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <charconv>
#include <cmath>
#include <map>
#include <numeric>
#include <span>
#include <tuple>

#include "common/base/error.hpp"

namespace tessera::report {
namespace {

[[noreturn]] void fail(const std::string& message, const std::string& name) {
  throw Error(ErrorKind::bad_input, message, {.file = name, .line = 0, .column = 0, .key = {}});
}

std::string setting(const image::ExrImage& exr, const std::string& attribute,
                    const std::string& name) {
  std::string text = exr.metadata.text(attribute);
  if (text.empty()) {
    fail(fmt::format("the header has no {}: is this a picture of Tessera's?", attribute), name);
  }
  return text;
}

template <class Number>
Number number(const image::ExrImage& exr, const std::string& attribute, const std::string& name) {
  const std::string text = setting(exr, attribute, name);
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size())
    fail(fmt::format("{} is \"{}\", expected a number", attribute, text), name);
  return value;
}

std::span<const float> plane(const image::ExrImage& exr, const std::string& channel,
                             const std::string& name) {
  if (!exr.has(channel)) fail(fmt::format("has no channel {}", channel), name);
  return exr.plane(channel);
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Of the mean, from the spread of the values; 0 for a single one.
double standard_error(const std::vector<double>& values) {
  if (values.size() < 2) return 0;
  const double center = mean(values);
  double sum = 0;
  for (const double value : values) sum += (value - center) * (value - center);
  const auto count = static_cast<double>(values.size());
  return std::sqrt(sum / (count - 1) / count);
}

void check_same_size(const Picture& picture, const Picture& other) {
  if (picture.width == other.width && picture.height == other.height) return;
  fail(fmt::format("has {}×{} pixels, but {} has {}×{}", picture.width, picture.height, other.name,
                   other.width, other.height),
       picture.name);
}

struct PictureErrors {
  double mse = 0, relative = 0, trimmed = 0;
};

PictureErrors errors_of(const Picture& picture, const Picture& reference) {
  check_same_size(picture, reference);
  const std::size_t pixels = picture.rgb[0].size();
  PictureErrors out;
  std::vector<double> relative(pixels);
  for (std::size_t i = 0; i < pixels; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      const double truth = reference.rgb[c][i];
      const double off = picture.rgb[c][i] - truth;
      out.mse += off * off;
      relative[i] += off * off / (truth * truth + 0.01) / 3;
    }
  }
  std::sort(relative.begin(), relative.end());
  const std::size_t kept = pixels - pixels / 1000;
  const auto middle = relative.begin() + static_cast<std::ptrdiff_t>(kept);
  const double sum = std::accumulate(relative.begin(), middle, 0.0);
  out.mse /= static_cast<double>(3 * pixels);
  out.trimmed = sum / static_cast<double>(kept);
  out.relative = std::accumulate(middle, relative.end(), sum) / static_cast<double>(pixels);
  return out;
}

}  // namespace

Picture picture_from(const image::ExrImage& exr, const std::string& name) {
  Picture picture;
  picture.name = name;
  picture.integrator = setting(exr, "tessera.integrator", name);
  picture.sampler = setting(exr, "tessera.sampler", name);
  picture.scene = setting(exr, "tessera.scene", name);
  picture.camera = exr.metadata.text("tessera.camera");
  picture.filter = setting(exr, "tessera.filter", name);
  picture.filter_width = number<double>(exr, "tessera.filter_width", name);
  picture.samples = number<std::int64_t>(exr, "tessera.samples", name);
  picture.light_samples = number<std::int64_t>(exr, "tessera.light_samples", name);
  picture.bounces = number<std::int64_t>(exr, "tessera.bounces", name);
  if (exr.metadata.find("tessera.cpu_seconds") != nullptr)
    picture.cpu_seconds = number<double>(exr, "tessera.cpu_seconds", name);
  picture.width = exr.width;
  picture.height = exr.height;
  const std::span<const float> counts = plane(exr, "samples", name);
  for (const float count : counts) {
    if (count != static_cast<float>(picture.samples))
      fail(fmt::format("a pixel has {} of {} samples: the job had not ended", count,
                       picture.samples),
           name);
  }
  constexpr std::array<const char*, 3> channels{"R", "G", "B"};
  double of_mean = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto color = plane(exr, channels[c], name);
    picture.rgb[c].assign(color.begin(), color.end());
    const auto variance = plane(exr, std::string("variance.") + channels[c], name);
    of_mean += std::accumulate(variance.begin(), variance.end(), 0.0) /
               static_cast<double>(3 * variance.size());
  }
  if (picture.samples > 1) picture.variance = of_mean * static_cast<double>(picture.samples);
  return picture;
}

std::vector<Cell> cells_of(const std::vector<Picture>& pictures) {
  const auto key = [](const Picture& p) {
    return std::tie(p.integrator, p.sampler, p.light_samples, p.bounces, p.samples, p.filter,
                    p.filter_width, p.camera, p.scene, p.width, p.height);
  };
  std::map<decltype(key(pictures.front())), Cell> sorted;
  for (const Picture& picture : pictures) sorted[key(picture)].pictures.push_back(&picture);
  std::vector<Cell> cells;
  cells.reserve(sorted.size());
  for (auto& [settings, cell] : sorted) cells.push_back(std::move(cell));
  return cells;
}

std::array<Mean, 3> means_of(const Cell& cell) {
  std::array<Mean, 3> means;
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<double> values;
    for (const Picture* picture : cell.pictures) {
      const std::vector<float>& plane = picture->rgb[c];
      values.push_back(std::accumulate(plane.begin(), plane.end(), 0.0) /
                       static_cast<double>(plane.size()));
    }
    means[c] = {mean(values), standard_error(values), static_cast<int>(values.size())};
  }
  return means;
}

Errors errors_of(const Cell& cell, const Picture& reference) {
  std::vector<double> mse;
  Errors out;
  for (const Picture* picture : cell.pictures) {
    const PictureErrors errors = errors_of(*picture, reference);
    mse.push_back(errors.mse);
    out.relative += errors.relative;
    out.trimmed += errors.trimmed;
    out.cpu_seconds += picture->cpu_seconds;
  }
  const auto count = static_cast<double>(cell.pictures.size());
  out.relative /= count;
  out.trimmed /= count;
  out.cpu_seconds /= count;
  out.mse = mean(mse);
  out.of_mse = standard_error(mse);
  return out;
}

Picture mean_picture(const std::vector<Picture>& pictures) {
  if (pictures.empty()) throw Error(ErrorKind::bad_input, "there is no picture to take a mean of");
  Picture out = pictures.front();
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<double> sums(out.rgb[c].size());
    for (const Picture& picture : pictures) {
      check_same_size(picture, out);
      for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += picture.rgb[c][i];
    }
    for (std::size_t i = 0; i < sums.size(); ++i)
      out.rgb[c][i] = static_cast<float>(sums[i] / static_cast<double>(pictures.size()));
  }
  return out;
}

WelchTest welch(const Mean& a, const Mean& b) {
  const double of_a = a.error * a.error;
  const double of_b = b.error * b.error;
  const double variance = of_a + of_b;
  if (a.pictures < 2 || b.pictures < 2 || !(variance > 0)) {
    throw Error(ErrorKind::failed, "a test of means needs two pictures of each, and some noise");
  }
  // Welch and Satterthwaite's degrees of freedom.
  const double freedom =
      variance * variance / (of_a * of_a / (a.pictures - 1) + of_b * of_b / (b.pictures - 1));
  WelchTest test;
  test.t = (a.value - b.value) / std::sqrt(variance);
  const boost::math::students_t distribution(freedom);
  test.p = 2 * boost::math::cdf(boost::math::complement(distribution, std::abs(test.t)));
  return test;
}

double sidak(double level, int tests) { return -std::expm1(std::log1p(-level) / tests); }

}  // namespace tessera::report
