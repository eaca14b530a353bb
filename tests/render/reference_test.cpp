#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <span>

#include "common/image/picture.hpp"
#include "common/scene/scene_file.hpp"
#include "tests/render/support.hpp"
#include "worker/scene/build.hpp"

/// Pictures against pictures of the integrator that takes uniform directions and knows no lamp:
/// tests/data/reference, made anew by make.sh there.
namespace tessera::render::proof {
namespace {

struct Reference {
  const char* picture;
  const char* scene;
};
const Reference references[] = {
    {"tests/data/reference/cornell.exr", "scenes/cornell.json"},
    {"tests/data/reference/lamps.exr", "tests/data/reference/lamps.json"}};

/// As make.sh asks for them.
constexpr int side = 32;
constexpr int bounces = 3;
constexpr int seeds = 16;
constexpr std::array<const char*, 3> colors{"R", "G", "B"};

double mean_of(std::span<const float> values) {
  double sum = 0;
  for (const float value : values) sum += double{value};
  return sum / static_cast<double>(values.size());
}

class Pictures : public testing::TestWithParam<Reference> {
 protected:
  Pictures()
      : reference_(image::read_exr_file(source_folder() / GetParam().picture)),
        scene_(worker::build_scene(scene::load_scene(source_folder() / GetParam().scene).scene,
                                   accel::Device())) {}

  [[nodiscard]] RenderedTask rendered(std::int64_t samples, std::uint64_t seed,
                                      const std::string& sampler, int depth = bounces) const {
    return render(scene_, {.side = side, .samples = samples, .bounces = depth, .sampler = sampler},
                  seed);
  }

  /// How far the picture's mean is off, in standard errors of both, by channel.
  [[nodiscard]] std::array<double, 3> deviations(int depth = bounces) const {
    std::array<std::vector<double>, 3> means;
    for (std::uint64_t seed = 0; seed < seeds; ++seed) {
      const RenderedTask done = rendered(64, seed, "sobol_owen", depth);
      for (std::size_t c = 0; c < 3; ++c)
        means.at(c).push_back(mean_of(done.image.plane(image::R + c)));
    }
    std::array<double, 3> off{};
    for (std::size_t c = 0; c < 3; ++c) {
      const auto variance = reference_.plane(std::string("variance.") + colors.at(c));
      const double expected = mean_of(reference_.plane(colors.at(c)));
      const Estimate own = estimate_of(means.at(c));
      const double error = std::sqrt(own.error * own.error +
                                     mean_of(variance) / static_cast<double>(variance.size()));
      EXPECT_LT(error, 0.004 * expected) << colors.at(c) << ": too noisy to say anything";
      off.at(c) = std::abs(own.mean - expected) / error;
    }
    return off;
  }

  image::ExrImage reference_;
  Scene scene_;
};

INSTANTIATE_TEST_SUITE_P(Hemisphere, Pictures, testing::ValuesIn(references), [](const auto& test) {
  return std::filesystem::path(test.param.picture).stem().string();
});

TEST_P(Pictures, have_the_references_pixels_by_a_z_test) {
  // Two-sided, at α = 1 − 0.99^(1/pixels) each (Šidák), of independent samples.
  constexpr std::int64_t samples = 1024;
  constexpr double bound = 4.42;  // of 1,024 pixels
  constexpr double least_variance = 1e-8;
  const RenderedTask done = rendered(samples, 5, "independent");
  const std::size_t pixels = done.image.pixels();
  for (std::size_t c = 0; c < 3; ++c) {
    const auto mean = reference_.plane(colors.at(c));
    const auto variance = reference_.plane(std::string("variance.") + colors.at(c));
    std::size_t off = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
      const double own = double{done.image.plane(image::M2_R + c)[i]} /
                         (static_cast<double>(samples) * static_cast<double>(samples - 1));
      const double z = (double{done.image.plane(image::R + c)[i]} - double{mean[i]}) /
                       std::sqrt(own + double{variance[i]} + least_variance);
      if (std::abs(z) > bound) ++off;
    }
    EXPECT_LE(static_cast<double>(off), 0.0025 * static_cast<double>(pixels)) << colors.at(c);
  }
}

TEST_P(Pictures, have_the_references_mean_by_a_t_test) {
  for (const double off : deviations()) EXPECT_LT(off, student_bound(seeds - 1));
}

TEST_P(Pictures, that_lack_bounces_fail_the_t_test) {
  for (const double off : deviations(1)) EXPECT_GT(off, student_bound(seeds - 1));
}

}  // namespace
}  // namespace tessera::render::proof
