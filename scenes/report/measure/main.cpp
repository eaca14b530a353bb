#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>

#include "common/base/error.hpp"
#include "scenes/report/measure/statistics.hpp"

namespace {

using namespace tessera::report;
namespace image = tessera::image;

std::vector<Picture> read(const std::vector<std::string>& files) {
  std::vector<Picture> pictures;
  pictures.reserve(files.size());
  for (const std::string& file : files)
    pictures.push_back(picture_from(image::read_exr_file(file), file));
  return pictures;
}

std::string settings_of(const Cell& cell) {
  const Picture& picture = cell.settings();
  return fmt::format("{}\t{}\t{}\t{}\t{}\t{}", picture.integrator, picture.sampler,
                     picture.light_samples, picture.bounces, picture.samples, cell.pictures.size());
}
constexpr const char* settings_head =
    "#integrator\tsampler\tlight_samples\tbounces\tsamples\tpictures";

void print_pictures(const std::vector<Picture>& pictures) {
  fmt::print("{}\tcpu_seconds\tmean\tsample_variance\tfile\n", settings_head);
  for (const Picture& picture : pictures) {
    const Cell alone{{&picture}};
    double mean = 0;
    for (const Mean& color : means_of(alone)) mean += color.value / 3;
    fmt::print("{}\t{:.6g}\t{:.7g}\t{}\t{}\n", settings_of(alone), picture.cpu_seconds, mean,
               picture.variance ? fmt::format("{:.6g}", *picture.variance) : "-", picture.name);
  }
}

void print_errors(const std::vector<Picture>& pictures, const std::vector<Picture>& references) {
  const Picture reference = mean_picture(references);
  fmt::print("{}\tcpu_seconds\tmse\tmse_error\trelmse\trelmse_trimmed\tsamples_mse\n",
             settings_head);
  for (const Cell& cell : cells_of(pictures)) {
    const Errors errors = errors_of(cell, reference);
    fmt::print("{}\t{:.6g}\t{:.6g}\t{:.2g}\t{:.6g}\t{:.6g}\t{:.6g}\n", settings_of(cell),
               errors.cpu_seconds, errors.mse, errors.of_mse, errors.relative, errors.trimmed,
               errors.mse * static_cast<double>(cell.settings().samples));
  }
}

/// True if no cell's mean differs from the reference's.
bool print_means(const std::vector<Picture>& pictures, const std::vector<Picture>& references,
                 double level) {
  Cell reference;
  for (const Picture& picture : references) reference.pictures.push_back(&picture);
  const std::array<Mean, 3> truth = means_of(reference);
  const std::vector<Cell> cells = cells_of(pictures);
  const double least = sidak(level, static_cast<int>(3 * cells.size()));
  fmt::print("{}\tmean_R\terror_R\tt_R\tmean_G\terror_G\tt_G\tmean_B\terror_B\tt_B\tleast_p\n",
             settings_head);
  bool same = true;
  for (const Cell& cell : cells) {
    const std::array<Mean, 3> means = means_of(cell);
    double p = 1;
    fmt::print("{}", settings_of(cell));
    for (std::size_t c = 0; c < 3; ++c) {
      const WelchTest test = welch(means[c], truth[c]);
      p = std::min(p, test.p);
      fmt::print("\t{:.6f}\t{:.6f}\t{:+.2f}", means[c].value, means[c].error, test.t);
    }
    fmt::print("\t{:.4f}\n", p);
    same = same && p >= least;
  }
  fmt::print(
      "# reference mean {:.6f} {:.6f} {:.6f}; {} tests at {:.3g} together: {} ({:.2g} each)\n",
      truth[0].value, truth[1].value, truth[2].value, 3 * cells.size(), level,
      same ? "no mean differs" : "A MEAN DIFFERS", least);
  return same;
}

int run(int argc, char** argv) {
  CLI::App app(
      "What rendered pictures say of the estimators that made them. Pictures whose headers differ "
      "in "
      "the seed alone are taken together.");
  app.require_subcommand(1);
  std::vector<std::string> files, references;
  double level = 0.01;
  const auto common = [&](CLI::App* command) {
    command->add_option("pictures", files, "EXR files")->required()->check(CLI::ExistingFile);
    command
        ->add_option("--reference", references,
                     "The truth: EXR files of other seeds, their mean is taken; all that follow")
        ->required()
        ->check(CLI::ExistingFile);
  };
  CLI::App* each =
      app.add_subcommand("pictures", "Mean and variance of a sample, a line per picture");
  each->add_option("pictures", files, "EXR files")->required()->check(CLI::ExistingFile);
  CLI::App* errors =
      app.add_subcommand("errors", "Distance from the reference, a line per setting");
  common(errors);
  CLI::App* means = app.add_subcommand(
      "means",
      "Welch's t-test of each setting's mean against the reference's; exit 1 if one differs");
  common(means);
  means->add_option("--level", level, "Of all tests together")->check(CLI::Range(1e-9, 0.5));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  const std::vector<Picture> pictures = read(files);
  if (*each) {
    print_pictures(pictures);
    return 0;
  }
  const std::vector<Picture> truth = read(references);
  if (*errors) {
    print_errors(pictures, truth);
    return 0;
  }
  return print_means(pictures, truth, level) ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const tessera::Error& error) {
    fmt::print(stderr, "tessera-statistics: {}\n", error.what());
    return tessera::exit_code(error.kind());
  } catch (const std::exception& error) {
    fmt::print(stderr, "tessera-statistics: {}\n", error.what());
    return 1;
  }
}
