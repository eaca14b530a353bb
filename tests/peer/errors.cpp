#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/peer/duel.hpp"

namespace {

using namespace tessera;

std::vector<report::Picture> read(const std::vector<std::string>& files) {
  std::vector<report::Picture> out;
  out.reserve(files.size());
  for (const std::string& file : files)
    out.push_back(peer::colors_of(image::read_exr_file(file), file));
  return out;
}

nlohmann::json told(const peer::Contender& of) {
  nlohmann::json means = nlohmann::json::array(), errors = nlohmann::json::array();
  for (const report::Mean& mean : of.means) {
    means.push_back(mean.value);
    errors.push_back(mean.error);
  }
  return {{"means", means},
          {"standard_errors", errors},
          {"relative", of.relative},
          {"trimmed", of.trimmed}};
}

}  // namespace

/// Compares what two renderers made of one scene with many seeds; prints one JSON object.
int main(int argc, char** argv) {
  CLI::App app("How far two renderers' pictures of one scene lie from the truth, as JSON");
  std::vector<std::string> first, second;
  app.add_option("--first", first, "EXR files of one renderer, one of each seed")->required();
  app.add_option("--second", second, "EXR files of the other")->required();
  CLI11_PARSE(app, argc, argv);
  try {
    const peer::Duel duel = peer::compare(read(first), read(second));
    nlohmann::json p = nlohmann::json::array();
    for (const report::WelchTest& test : duel.means) p.push_back(test.p);
    const nlohmann::json out{{"first", told(duel.first)},
                             {"second", told(duel.second)},
                             {"p", p},
                             {"level", peer::level},
                             {"beyond_pixels", duel.beyond.pixels},
                             {"beyond_blocks", duel.beyond.blocks}};
    fmt::print("{}\n", out.dump());
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "peer_errors: {}\n", error.what());
    return 2;
  }
}
