#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/image/picture.hpp"

/// What rendered pictures say of the estimators that made them. Pure.
namespace tessera::report {

/// A picture's colours, and those of its settings that its header names.
struct Picture {
  std::string name;  ///< for errors
  std::string integrator, sampler;
  std::string scene, camera, filter;  ///< scene: its bundle's digest
  double filter_width = 0;
  std::int64_t samples = 0;
  std::int64_t light_samples = 0;
  std::int64_t bounces = 0;
  double cpu_seconds = 0;  ///< of rendering, all workers'; 0 if the header does not say
  /// Of one sample, by the picture's own word; mean over pixels and colours. Nothing for a picture
  /// of one sample, which cannot know.
  std::optional<double> variance;
  int width = 0, height = 0;
  std::array<std::vector<float>, 3> rgb;  ///< row by row from the upper left
};

/// Throws Error{bad_input}, with `name` as its place, if the picture lacks a channel or a setting,
/// or a pixel has not all of the job's samples.
Picture picture_from(const image::ExrImage& exr, const std::string& name);

/// Pictures that differ, as far as Picture holds, in their seed alone.
struct Cell {
  std::vector<const Picture*> pictures;
  [[nodiscard]] const Picture& settings() const { return *pictures.front(); }
};
/// By integrator, sampler, light samples, bounces, samples, in this order; what else they differ in
/// parts them too.
std::vector<Cell> cells_of(const std::vector<Picture>& pictures);

/// The mean over a cell's pictures of each picture's own mean, and what is known of its error.
struct Mean {
  double value = 0;
  double error = 0;  ///< standard error, from the spread between pictures; 0 for a single picture
  int pictures = 0;
};
/// One for R, G and B.
std::array<Mean, 3> means_of(const Cell& cell);

/// How far a cell's pictures lie from a reference, the mean over pixels, colours and pictures.
struct Errors {
  double mse = 0;          ///< (x − r)²
  double relative = 0;     ///< (x − r)² / (r² + 0.01), as in Rousselle et al. 2011
  double trimmed = 0;      ///< the same without the worst .1 % of a picture's pixels
  double of_mse = 0;       ///< standard error of mse, from the spread between pictures
  double cpu_seconds = 0;  ///< of one picture, the mean
};
/// Throws Error{bad_input} if sizes differ.
Errors errors_of(const Cell& cell, const Picture& reference);

/// The mean picture of several of one size; its settings are the first's. Throws Error{bad_input}.
Picture mean_picture(const std::vector<Picture>& pictures);

/// Welch's test of two means of unknown and different variances (Welch 1947): t, and the two-sided
/// probability of one as large if both estimate the same. Each mean needs two pictures or more, one
/// of the two at least an error above 0; anything else is a mistake of the caller's.
struct WelchTest {
  double t = 0;
  double p = 1;
};
WelchTest welch(const Mean& a, const Mean& b);

/// The level of each of `tests` independent tests by which all of them together have the level
/// `level` (Šidák 1967): 1 − (1 − level)^(1/tests).
double sidak(double level, int tests);

}  // namespace tessera::report
