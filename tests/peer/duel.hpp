#pragma once
#include <array>
#include <string>
#include <vector>

#include "scenes/report/measure/statistics.hpp"

/// What pictures of one scene by two renderers, many seeds of each, say of their truth and noise.
namespace tessera::peer {

/// Of one renderer's pictures.
struct Contender {
  std::array<report::Mean, 3> means;
  double relative = 0;  ///< error of a picture, the mean over the pictures: see report::Errors
  double trimmed = 0;
};

/// Shares of places whose two means differ more than Welch's t-test allows at `level`; of tests of
/// the truth alone it would be `level` or, where noise has long tails, less.
struct Beyond {
  double pixels = 0;  ///< of pixels' colours
  double blocks = 0;  ///< of the colours of blocks of block_side pixels
};

struct Duel {
  Contender first, second;
  std::array<report::WelchTest, 3> means;
  Beyond beyond;
};

constexpr double level = 0.001;

/// The colours alone; throws Error{bad_input}, naming the file, where a channel lacks.
report::Picture colors_of(const image::ExrImage& exr, const std::string& name);

/// Each picture's error is its distance from the mean of all others, its own renderer's and the
/// other's, weighed by what noise they have. What noise that mean has left counts against both
/// alike; it is at most a share of 1 / (pictures − 1) of the less noisy one's own. Needs three
/// pictures of each, of one size; throws Error{bad_input} else.
Duel compare(const std::vector<report::Picture>& first, const std::vector<report::Picture>& second);

}  // namespace tessera::peer
