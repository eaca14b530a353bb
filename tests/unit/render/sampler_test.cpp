#include "worker/render/sampler.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "common/base/error.hpp"
#include "tests/unit/render/chi2.hpp"

namespace tessera::render {
namespace {

using Point = std::array<std::uint32_t, 4>;

Point point_of(const Sampler& sampler, std::uint32_t set) {
  const Draw4 draw = sampler.draw4(set);
  return {draw.bits(0), draw.bits(1), draw.bits(2), draw.bits(3)};
}

/// Points of one set, of samples first … first + count − 1.
std::vector<Point> points_of(SamplerKind kind, std::uint32_t x, std::uint32_t y, std::uint32_t set,
                             std::uint64_t first, std::uint64_t count) {
  std::vector<Point> points;
  for (std::uint64_t i = first; i < first + count; ++i) {
    points.push_back(point_of(Sampler(kind, 7, x, y, i), set));
  }
  return points;
}

/// True if each of the boxes that cut axis d into 2^cuts[d] pieces holds equally many of the
/// points.
bool boxes_hold_equally(const std::vector<Point>& points, const std::array<int, 4>& cuts) {
  const int total = cuts[0] + cuts[1] + cuts[2] + cuts[3];
  std::vector<std::size_t> count(std::size_t{1} << total, 0);
  for (const Point& p : points) {
    std::size_t box = 0;
    for (std::size_t d = 0; d < 4; ++d) {
      if (cuts[d] > 0) box = box << cuts[d] | p[d] >> (32 - cuts[d]);
    }
    ++count[box];
  }
  const std::size_t each = points.size() >> total;
  return std::all_of(count.begin(), count.end(), [&](std::size_t c) { return c == each; });
}

/// Sobol's dimensions 0 … 3 come of polynomials of degree 1 (van der Corput), 1, 2, 3: projected on
/// some of them, 2^k points lie evenly in all elementary boxes of which there are 2^(k − t), where
/// t is the sum of (degree − 1).
int t_of(const std::array<int, 4>& cuts) { return (cuts[2] > 0 ? 1 : 0) + (cuts[3] > 0 ? 2 : 0); }

void expect_elementary_intervals(const std::vector<Point>& points, int k, std::uint32_t set) {
  for (int a = 0; a <= k; ++a) {
    for (int b = 0; a + b <= k; ++b) {
      for (int c = 0; a + b + c <= k; ++c) {
        for (int d = 0; a + b + c + d <= k; ++d) {
          const std::array<int, 4> cuts = {a, b, c, d};
          if (a + b + c + d != k - t_of(cuts)) continue;
          ASSERT_TRUE(boxes_hold_equally(points, cuts))
              << "set " << set << ", 2^" << k << " samples, cuts " << a << b << c << d;
        }
      }
    }
  }
}

TEST(Sampler, EveryAlignedPassOfEverySetHasItsElementaryIntervals) {
  constexpr std::uint64_t total = 256;
  for (const SamplerKind kind : {SamplerKind::sobol_owen, SamplerKind::sobol}) {
    for (std::uint32_t set = 0; set < dim::bsdf_set(4); ++set) {
      for (int k = 0; k <= 8; ++k) {
        const std::uint64_t size = std::uint64_t{1} << k;
        for (std::uint64_t first = 0; first < total; first += size) {
          expect_elementary_intervals(points_of(kind, 5, 9, set, first, size), k, set);
        }
      }
    }
  }
}

TEST(Sampler, IndependentNumbersHaveNoElementaryIntervals) {
  // So the check above can fail.
  EXPECT_FALSE(
      boxes_hold_equally(points_of(SamplerKind::independent, 5, 9, 2, 0, 256), {4, 4, 0, 0}));
}

TEST(Sampler, ALaterPassHasItsElementaryIntervalsToo) {
  for (const SamplerKind kind : {SamplerKind::sobol_owen, SamplerKind::sobol}) {
    for (const std::uint32_t set : {dim::film_set, dim::bsdf_set(0), dim::light_set(3)}) {
      expect_elementary_intervals(points_of(kind, 0, 0, set, 3 * 1024, 1024), 10, set);
      // Across the end of the sequence's 2^32 points another begins, as even as it.
      expect_elementary_intervals(points_of(kind, 0, 0, set, 5ULL << 32, 256), 8, set);
    }
  }
}

TEST(Sampler, LightSamplesOfOneSampleGoOnThroughTheSequence) {
  std::vector<Point> points;
  for (std::uint64_t i = 0; i < 64; ++i) {
    const Sampler sampler(SamplerKind::sobol_owen, 7, 3, 4, i);
    for (std::uint32_t j = 0; j < 4; ++j) {
      const Draw4 draw = sampler.draw4(dim::light_set(1), j, 4);
      points.push_back({draw.bits(0), draw.bits(1), draw.bits(2), draw.bits(3)});
    }
  }
  EXPECT_EQ(points, points_of(SamplerKind::sobol_owen, 3, 4, dim::light_set(1), 0, 256));
  expect_elementary_intervals(points, 8, dim::light_set(1));
}

TEST(Sampler, TablesGiveSobolsSequence) {
  // Joe and Kuo's first points: 0, then halves, then quarters in the order that their directions
  // give.
  const std::array<std::array<double, 4>, 4> known = {
      {{0, 0, 0, 0}, {.5, .5, .5, .5}, {.25, .75, .75, .75}, {.75, .25, .25, .25}}};
  for (std::uint32_t i = 0; i < 4; ++i) {
    for (std::uint32_t d = 0; d < 4; ++d) {
      EXPECT_EQ(sobol_plain(i, d) * 0x1p-32, known[i][d]) << i << ' ' << d;
    }
  }
  // Owen's scrambling keeps how many leading bits two points share, so the pairs of a draw show the
  // tables' points. The index is shuffled in the same way, so i and j keep how many trailing places
  // they share, and the sets of shared bits agree.
  const auto shared_bits = [](std::uint32_t a, std::uint32_t b) { return std::countl_zero(a ^ b); };
  for (std::uint32_t d = 0; d < 4; ++d) {
    std::vector<int> plain, scrambled;
    for (std::uint32_t i = 0; i < 256; ++i) {
      for (std::uint32_t j = 0; j < i; ++j) {
        plain.push_back(shared_bits(sobol_plain(i, d), sobol_plain(j, d)));
        const auto bits = [&](std::uint32_t sample) {
          return Sampler(SamplerKind::sobol_owen, 1, 2, 3, sample).draw4(5).bits(d);
        };
        scrambled.push_back(shared_bits(bits(i), bits(j)));
      }
    }
    std::sort(plain.begin(), plain.end());
    std::sort(scrambled.begin(), scrambled.end());
    // Pairs that share all eight bits of the interval differ below it, where scrambling decides.
    for (int& n : plain) n = std::min(n, 8);
    for (int& n : scrambled) n = std::min(n, 8);
    EXPECT_EQ(plain, scrambled) << d;
  }
}

class EverySampler : public testing::TestWithParam<std::string_view> {
 protected:
  [[nodiscard]] static SamplerKind kind() { return sampler_kind(GetParam()); }
};
INSTANTIATE_TEST_SUITE_P(Names, EverySampler, testing::ValuesIn(sampler_names()),
                         [](const auto& test) { return std::string(test.param); });

TEST_P(EverySampler, ANumberIsTheSameWhereverOneComesFrom) {
  std::vector<float> forwards, backwards;
  const Sampler once(kind(), 11, 17, 23, 42);
  for (std::uint32_t d = 0; d < 200; ++d) forwards.push_back(once.draw1(d));
  for (std::uint32_t d = 200; d-- > 0;) {
    (void)Sampler(kind(), 11, 1, 2, d).draw4(d);
    backwards.push_back(Sampler(kind(), 11, 17, 23, 42).draw1(d));
  }
  std::reverse(backwards.begin(), backwards.end());
  EXPECT_EQ(forwards, backwards);
  EXPECT_EQ(once.draw2(8).x, forwards[8]);
  EXPECT_EQ(once.draw2(8).y, forwards[9]);
  EXPECT_EQ(once.draw2(10).x, forwards[10]);
  EXPECT_EQ(once.draw4(3)[2], forwards[14]);
}

TEST_P(EverySampler, NumbersStayBelowOne) {
  EXPECT_LT(unit_float(0xffffffffU), 1.0F);
  float least = 1, most = 0;
  for (std::uint64_t i = 0; i < 50'000; ++i) {
    const Draw4 draw = Sampler(kind(), 1, 0, 0, i).draw4(2);
    for (std::uint32_t place = 0; place < 4; ++place) {
      least = std::min(least, draw[place]);
      most = std::max(most, draw[place]);
    }
  }
  EXPECT_GE(least, 0.0F);
  EXPECT_LT(most, 1.0F);
  EXPECT_LT(least, 1e-4F);
  EXPECT_GT(most, 1 - 1e-4F);
}

TEST_P(EverySampler, TheFirstNumbersOfManyPixelsAreUniform) {
  // One number of each of 65536 pixels: independent of each other, so chi² applies to either
  // sampler.
  for (std::uint32_t dimension = 0; dimension < 4 * dim::bsdf_set(1); dimension += 3) {
    std::vector<double> observed(64, 0.0);
    for (std::uint32_t y = 0; y < 256; ++y) {
      for (std::uint32_t x = 0; x < 256; ++x) {
        const float u = Sampler(kind(), 5, x, y, 3).draw1(dimension);
        observed[static_cast<std::size_t>(u * 64)] += 1;
      }
    }
    EXPECT_EQ(test::chi2_compare(observed, std::vector<double>(64, 1024.0)), "") << dimension;
  }
}

/// Largest correlation between the numbers of `a` and `b`, times sqrt(n): about a normal deviate if
/// they are independent.
double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - 0.5) * (b[i] - 0.5) * 12;
  return std::abs(sum / std::sqrt(static_cast<double>(a.size())));
}

TEST_P(EverySampler, SetsAndSeedsAndNeighboursAreNotCorrelated) {
  const auto numbers = [&](std::uint64_t seed, std::uint32_t dx, std::uint32_t dy,
                           std::uint32_t dimension) {
    std::vector<double> values;
    for (std::uint32_t y = 0; y < 128; ++y) {
      for (std::uint32_t x = 0; x < 128; ++x) {
        values.push_back(
            static_cast<double>(Sampler(kind(), seed, x + dx, y + dy, 0).draw1(dimension)));
      }
    }
    return values;
  };
  const std::vector<double> base = numbers(1, 0, 0, 8);
  EXPECT_LT(correlation(base, numbers(1, 1, 0, 8)), 4.5) << "the pixel to the right";
  EXPECT_LT(correlation(base, numbers(1, 0, 1, 8)), 4.5) << "the pixel below";
  EXPECT_LT(correlation(base, numbers(2, 0, 0, 8)), 4.5) << "another seed";
  for (std::uint32_t dimension = 0; dimension < 40; ++dimension) {
    if (dimension != 8) {
      EXPECT_LT(correlation(base, numbers(1, 0, 0, dimension)), 4.5) << dimension;
    }
  }
}

TEST_P(EverySampler, PairsFromTwoSetsFillTheSquare) {
  // Padding: within a pixel, a set's numbers against another's, over all samples of many pixels.
  std::vector<double> observed(256, 0.0);
  for (std::uint32_t pixel = 0; pixel < 16384; ++pixel) {
    const Sampler sampler(kind(), 3, pixel, 1, pixel % 16);
    const float a = sampler.draw1(4 * dim::bsdf_set(0)), b = sampler.draw1(4 * dim::bsdf_set(1));
    observed[static_cast<std::size_t>(a * 16) * 16 + static_cast<std::size_t>(b * 16)] += 1;
  }
  EXPECT_EQ(test::chi2_compare(observed, std::vector<double>(256, 64.0)), "");
}

TEST_P(EverySampler, BitsAreTheOnesOnRecord) {
  // If this changes, pictures change: only on purpose.
  const std::map<std::string_view, std::uint64_t> on_record = {
      {"sobol_owen", 606152821893437770ULL},    {"sobol", 11970201050339015529ULL},
      {"independent", 11224077067479017333ULL}, {"pcg", 1161148989725272037ULL},
      {"xorshift", 4520754233057605547ULL},     {"mt19937", 1340775705843194821ULL}};
  std::uint64_t hash = 0;
  for (std::uint32_t i = 0; i < 4096; ++i) {
    const Sampler sampler(kind(), 1 + i % 3, i * 7 % 640, i * 11 % 480, std::uint64_t{i} * i * i);
    const Draw4 draw = sampler.draw4(i % 40);
    for (std::uint32_t place = 0; place < 4; ++place) hash = hash_combine(hash, draw.bits(place));
  }
  EXPECT_EQ(hash, on_record.at(GetParam()));
}

TEST(Sampler, SobolIntegratesBetterThanChance) {
  // ∫ of a smooth function of four numbers, by 256 samples of each of 200 pixels: the mean square
  // of the error.
  const auto error = [](SamplerKind kind) {
    double sum = 0;
    for (std::uint32_t pixel = 0; pixel < 200; ++pixel) {
      double mean = 0;
      for (std::uint64_t i = 0; i < 256; ++i) {
        const Draw4 u = Sampler(kind, 1, pixel, 0, i).draw4(dim::light_set(0));
        mean += static_cast<double>(u[0] * u[1] + u[2] * u[3]) / 256;
      }
      sum += (mean - 0.5) * (mean - 0.5);
    }
    return sum;
  };
  EXPECT_LT(error(SamplerKind::sobol_owen), 0.02 * error(SamplerKind::independent));
}

TEST(Sampler, AnUnknownNameIsAnErrorThatListsTheValidOnes) {
  EXPECT_EQ(sampler_kind("sobol_owen"), SamplerKind::sobol_owen);
  EXPECT_THAT([] { sampler_kind("sobol_own"); },
              testing::ThrowsMessage<Error>(testing::AllOf(testing::HasSubstr("sobol_owen"),
                                                           testing::HasSubstr("independent"))));
}

TEST(Hash, AlphaNumbersAreUniformAndDependOnWhatIsHit) {
  std::vector<double> observed(32, 0.0);
  for (std::uint32_t i = 0; i < 32'000; ++i) {
    const std::uint64_t sample = Sampler(SamplerKind::sobol_owen, 1, i % 16, 3, i / 16).hash();
    observed[static_cast<std::size_t>(alpha_number(sample, i % 3, i % 5, i) * 32)] += 1;
  }
  EXPECT_EQ(test::chi2_compare(observed, std::vector<double>(32, 1000.0)), "");
  EXPECT_NE(alpha_number(1, 0, 0, 0), alpha_number(1, 1, 0, 0));
  EXPECT_NE(alpha_number(1, 0, 1, 0), alpha_number(1, 0, 0, 1));
}

TEST(PixelSets, GiveTheSamplesOfTheirPixelTheSameNumbers) {
  PixelSets sets;
  for (const std::uint32_t x : {3U, 4U}) {
    sets.start(pixel_hash(7, x, 5));
    for (const std::string_view name : sampler_names()) {
      const SamplerKind kind = sampler_kind(name);
      for (const std::uint64_t sample :
           {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{0x89abcdefU},
            std::uint64_t{0xffffffffU}, std::uint64_t{0x1'0000'0003U}}) {
        const Sampler alone(kind, 7, x, 5, sample), shared(kind, sets, sample);
        EXPECT_EQ(shared.hash(), alone.hash());
        for (const std::uint32_t set : {0U, 1U, 2U, 63U, 64U, 1000U}) {
          EXPECT_EQ(point_of(shared, set), point_of(alone, set)) << name << ' ' << sample;
          for (std::uint32_t j = 0; j < 3; ++j) {
            EXPECT_EQ(shared.draw4(set, j, 3).bits(1), alone.draw4(set, j, 3).bits(1)) << name;
          }
          EXPECT_EQ(shared.draw4(set, 0, 1).bits(2), alone.draw4(set).bits(2)) << name;
        }
      }
    }
  }
}

}  // namespace
}  // namespace tessera::render
