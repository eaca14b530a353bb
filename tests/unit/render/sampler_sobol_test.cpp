#include "worker/render/sampler_sobol.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "tests/unit/render/chi2.hpp"
#include "worker/render/sampler.hpp"

/// What the two samplers made of Sobol's sequence owe to padding, shifting and scrambling.
namespace tessera::render {
namespace {

using Pair = std::pair<std::uint32_t, std::uint32_t>;

/// How often pairs fall into each of 16×16 cells.
std::vector<double> cells(const std::function<Pair(std::uint32_t)>& pair, std::uint32_t count) {
  std::vector<double> observed(256, 0.0);
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto [a, b] = pair(i);
    observed[(a >> 28 << 4) | b >> 28] += 1;
  }
  return observed;
}

class SobolSampler : public testing::TestWithParam<SamplerKind> {
 protected:
  [[nodiscard]] static Draw4 draw(std::uint32_t pixel, std::uint32_t set, std::uint64_t sample) {
    return Sampler(GetParam(), 5, pixel, 3, sample).draw4(set);
  }
};
INSTANTIATE_TEST_SUITE_P(Kinds, SobolSampler,
                         testing::Values(SamplerKind::sobol_owen, SamplerKind::sobol),
                         [](const auto& test) {
                           return test.param == SamplerKind::sobol ? "sobol" : "sobol_owen";
                         });

TEST_P(SobolSampler, SetsOfOnePixelAreNotCopiesOfEachOther) {
  // All sets use the same four dimensions. Within one pixel, each place of a set against the same
  // place of others: pairs that lay on a line would give a path of two bounces a wrong mean.
  const std::vector<double> even(256, 16.0);
  for (const std::uint32_t other :
       {dim::film_set, dim::light_set(0), dim::bsdf_set(1), dim::light_set(1), dim::bsdf_set(7)}) {
    for (std::uint32_t place = 0; place < 4; ++place) {
      for (std::uint32_t pixel = 0; pixel < 4; ++pixel) {
        const auto pair = [&](std::uint32_t i) {
          return Pair{draw(pixel, dim::bsdf_set(0), i).bits(place),
                      draw(pixel, other, i).bits(place)};
        };
        EXPECT_EQ(test::chi2_compare(cells(pair, 4096), even), "")
            << "set " << other << ", place " << place << ", pixel " << pixel;
      }
    }
  }
}

TEST(Sobol, SetsInOneOrderWouldBeCopies) {
  // So the test above can fail: shifted points, and a shifted index besides.
  for (const std::uint32_t index_shift : {0U, 1234U}) {
    const auto pair = [&](std::uint32_t i) {
      return Pair{sobol_plain(i, 1) ^ 0x12345678U, sobol_plain(i ^ index_shift, 1) ^ 0x9abcdef0U};
    };
    EXPECT_NE(test::chi2_compare(cells(pair, 4096), std::vector<double>(256, 16.0)), "");
  }
}

TEST_P(SobolSampler, AProductOverSetsHasItsMean) {
  // ∫ Π (½ + u) over the first numbers of five bounces is 1. Copies would give ∫ (½ + u)^5 = 2.27
  // and shifted copies something else than 1 in each pixel.
  std::vector<double> means;
  for (std::uint32_t pixel = 0; pixel < 64; ++pixel) {
    double sum = 0;
    for (std::uint64_t i = 0; i < 1024; ++i) {
      double product = 1;
      for (std::uint32_t bounce = 0; bounce < 5; ++bounce) {
        product *= 0.5 + static_cast<double>(draw(pixel, dim::bsdf_set(bounce), i)[0]);
      }
      sum += product;
    }
    means.push_back(sum / 1024);
  }
  // Plain Monte Carlo's variance is ((13/12)^5 − 1)/1024 a pixel; stratified, each is well below.
  double mean = 0, square = 0;
  for (const double value : means) {
    mean += value / 64;
    square += (value - 1) * (value - 1) / 64;
  }
  EXPECT_LT(square, 0.5 / 1024);
  EXPECT_NEAR(mean, 1, 4 * 0.022 / 8);
}

/// Mean square of the error over 256 pixels, of ∫ u·v over one set's first pair by `samples`.
double error_square(SamplerKind kind, std::uint64_t samples) {
  double sum = 0;
  for (std::uint32_t pixel = 0; pixel < 256; ++pixel) {
    double mean = 0;
    for (std::uint64_t i = 0; i < samples; ++i) {
      const Draw4 u = Sampler(kind, 1, pixel, 0, i).draw4(dim::bsdf_set(0));
      mean += static_cast<double>(u.bits(0)) * static_cast<double>(u.bits(1)) * 0x1p-64 /
              static_cast<double>(samples);
    }
    sum += (mean - 0.25) * (mean - 0.25) / 256;
  }
  return sum;
}

TEST(Sobol, ScramblingConvergesAnOrderFasterThanShifting) {
  // From 64 samples to 1024, sixteen times as many, variances of a smooth integrand fall by 16
  // independently drawn, by about 16² shifted, by about 16³ scrambled.
  const auto gain = [](SamplerKind kind) {
    return error_square(kind, 64) / error_square(kind, 1024);
  };
  const double plain = gain(SamplerKind::pcg), shifted = gain(SamplerKind::sobol),
               scrambled = gain(SamplerKind::sobol_owen);
  EXPECT_GT(plain, 10);
  EXPECT_LT(plain, 26);
  EXPECT_GT(shifted, 120);
  EXPECT_LT(shifted, 400);
  EXPECT_GT(scrambled, 1000);
}

TEST(Sobol, PixelsAreShiftedApart) {
  // Without shifts, one sample of each pixel would be the same point in all.
  std::vector<double> observed(64, 0.0);
  for (std::uint32_t pixel = 0; pixel < 6400; ++pixel) {
    const Sampler sampler(SamplerKind::sobol, 1, pixel % 80, pixel / 80, 0);
    observed[sampler.draw4(dim::film_set).bits(0) >> 26] += 1;
  }
  EXPECT_EQ(test::chi2_compare(observed, std::vector<double>(64, 100.0)), "");
}

TEST(Sobol, ASetIsTheSequenceShiftedInAnotherOrder) {
  // The differences of all pairs, as sets, are the sequence's own: a shift falls out of them.
  for (std::uint32_t d = 0; d < 4; ++d) {
    std::vector<std::uint32_t> plain, drawn;
    for (std::uint32_t i = 0; i < 64; ++i) {
      for (std::uint32_t j = 0; j < i; ++j) {
        const auto bits = [&](std::uint64_t sample) {
          return Sampler(SamplerKind::sobol, 1, 2, 3, sample).draw4(6).bits(d) >> 26;
        };
        plain.push_back((sobol_plain(i, d) ^ sobol_plain(j, d)) >> 26);
        drawn.push_back(bits(i) ^ bits(j));
      }
    }
    std::sort(plain.begin(), plain.end());
    std::sort(drawn.begin(), drawn.end());
    EXPECT_EQ(plain, drawn) << d;
  }
}

}  // namespace
}  // namespace tessera::render
