#include "tests/peer/duel.hpp"

#include <algorithm>
#include <cmath>

#include "common/base/error.hpp"
#include "tests/peer/likeness.hpp"

namespace tessera::peer {

namespace {

using report::Picture;

/// Sums over one renderer's pictures, of each pixel's colours.
struct Sums {
  std::size_t pictures = 0;
  std::array<std::vector<double>, 3> sum, squares;

  explicit Sums(const std::vector<Picture>& all) : pictures(all.size()) {
    for (std::size_t c = 0; c < 3; ++c) {
      sum[c].resize(all[0].rgb[c].size());
      squares[c].resize(sum[c].size());
      for (const Picture& picture : all)
        for (std::size_t i = 0; i < sum[c].size(); ++i) {
          const double value = picture.rgb[c][i];
          sum[c][i] += value;
          squares[c][i] += value * value;
        }
    }
  }

  [[nodiscard]] report::Mean mean(std::size_t c, std::size_t i) const {
    const auto count = static_cast<double>(pictures);
    const double mean = sum[c][i] / count;
    const double variance = std::max(0.0, squares[c][i] / count - mean * mean) / (count - 1);
    return {.value = mean, .error = std::sqrt(variance), .pictures = static_cast<int>(pictures)};
  }
  /// A picture's variance, the mean over pixels and colours, over their squares as errors have it.
  [[nodiscard]] double noise() const {
    double out = 0;
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t i = 0; i < sum[c].size(); ++i) {
        const report::Mean of = mean(c, i);
        out += of.error * of.error / (of.value * of.value + 0.01);
      }
    return out * static_cast<double>(pictures) / static_cast<double>(3 * sum[0].size());
  }
};

/// The mean of `own` without `picture`, and of `other`; each weighs what its noise lets it.
Picture reference_for(const Picture& picture, const Sums& own, const Sums& other, double own_noise,
                      double other_noise) {
  const auto own_count = static_cast<double>(own.pictures - 1);
  const auto other_count = static_cast<double>(other.pictures);
  const double both = own_noise * other_count + other_noise * own_count;
  const double of_own = both > 0 ? other_noise * own_count / both : 0.5;
  Picture out = picture;
  out.name = "the mean of the others";
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t i = 0; i < out.rgb[c].size(); ++i) {
      const double mine = (own.sum[c][i] - picture.rgb[c][i]) / own_count;
      const double theirs = other.sum[c][i] / other_count;
      out.rgb[c][i] = static_cast<float>(of_own * mine + (1 - of_own) * theirs);
    }
  return out;
}

Contender contender(const std::vector<Picture>& pictures, const Sums& own, const Sums& other) {
  Contender out;
  report::Cell all;
  const double own_noise = own.noise(), other_noise = other.noise();
  for (const Picture& picture : pictures) {
    all.pictures.push_back(&picture);
    const report::Errors errors = report::errors_of(
        report::Cell{{&picture}}, reference_for(picture, own, other, own_noise, other_noise));
    out.relative += errors.relative / static_cast<double>(pictures.size());
    out.trimmed += errors.trimmed / static_cast<double>(pictures.size());
  }
  out.means = report::means_of(all);
  return out;
}

/// Where neither has any noise, a rounding error apart is no difference.
bool differ(const report::Mean& a, const report::Mean& b) {
  const double off = std::abs(a.value - b.value);
  if (off <= 1e-5 * std::max(std::abs(a.value), std::abs(b.value))) return false;
  if (!(a.error + b.error > 0)) return true;
  return report::welch(a, b).p < level;
}

double share_that_differs(const Sums& a, const Sums& b) {
  std::size_t beyond = 0;
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t i = 0; i < a.sum[c].size(); ++i)
      if (differ(a.mean(c, i), b.mean(c, i))) ++beyond;
  return static_cast<double>(beyond) / static_cast<double>(3 * a.sum[0].size());
}

/// Means over blocks; what is left of one at the right and lower edge is a block too.
std::vector<Picture> in_blocks(const std::vector<Picture>& pictures) {
  std::vector<Picture> out;
  for (const Picture& picture : pictures) {
    Picture& made = out.emplace_back();
    made.name = picture.name;
    made.width = (picture.width + block_side - 1) / block_side;
    made.height = (picture.height + block_side - 1) / block_side;
    const auto blocks =
        static_cast<std::size_t>(made.width) * static_cast<std::size_t>(made.height);
    for (std::size_t c = 0; c < 3; ++c) {
      std::vector<double> sum(blocks), count(blocks);
      for (std::size_t i = 0; i < picture.rgb[c].size(); ++i) {
        const auto width = static_cast<std::size_t>(picture.width);
        const std::size_t block =
            i / width / block_side * static_cast<std::size_t>(made.width) + i % width / block_side;
        sum[block] += picture.rgb[c][i];
        ++count[block];
      }
      for (std::size_t i = 0; i < blocks; ++i)
        made.rgb[c].push_back(static_cast<float>(sum[i] / count[i]));
    }
  }
  return out;
}

void check(const std::vector<Picture>& pictures, const Picture& size) {
  if (pictures.size() < 3)
    throw Error(ErrorKind::bad_input, "a duel needs three pictures of each renderer");
  for (const Picture& picture : pictures)
    if (picture.width != size.width || picture.height != size.height)
      throw Error(ErrorKind::bad_input, picture.name + " has another size than " + size.name);
}

}  // namespace

Picture colors_of(const image::ExrImage& exr, const std::string& name) {
  Picture out;
  out.name = name;
  out.width = exr.width;
  out.height = exr.height;
  constexpr std::array<const char*, 3> channels{"R", "G", "B"};
  for (std::size_t c = 0; c < 3; ++c) {
    if (!exr.has(channels[c]))
      throw Error(ErrorKind::bad_input, name + " has no channel " + channels[c]);
    const auto plane = exr.plane(channels[c]);
    out.rgb[c].assign(plane.begin(), plane.end());
  }
  return out;
}

Duel compare(const std::vector<Picture>& first, const std::vector<Picture>& second) {
  check(first, first.empty() ? Picture{} : first[0]);
  check(second, first[0]);
  const Sums a(first), b(second);
  Duel out;
  out.first = contender(first, a, b);
  out.second = contender(second, b, a);
  for (std::size_t c = 0; c < 3; ++c) {
    const report::Mean& one = out.first.means[c];
    const report::Mean& other = out.second.means[c];
    if (one.error + other.error > 0) out.means[c] = report::welch(one, other);
  }
  const Sums of_a(in_blocks(first)), of_b(in_blocks(second));
  out.beyond = {.pixels = share_that_differs(a, b), .blocks = share_that_differs(of_a, of_b)};
  return out;
}

}  // namespace tessera::peer
