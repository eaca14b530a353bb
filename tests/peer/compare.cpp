#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "common/base/files.hpp"
#include "tests/peer/likeness.hpp"

/// Compares two pictures of one scene, and prints how alike they are as one JSON object.
int main(int argc, char** argv) {
  using namespace tessera;
  CLI::App app("How alike two pictures of one scene are, as JSON");
  std::string first, second, sheet;
  app.add_option("FIRST", first, "An EXR file")->required();
  app.add_option("SECOND", second, "The one to compare it with")->required();
  app.add_option("-o,--output", sheet, "A PNG: the first, the second, their difference");
  CLI11_PARSE(app, argc, argv);
  try {
    const image::ExrImage a = image::read_exr_file(first), b = image::read_exr_file(second);
    const peer::Likeness like = peer::compare(a, b);
    if (!sheet.empty()) write_file_atomically(sheet, peer::side_by_side(a, b));
    const nlohmann::json out{{"first", like.first},
                             {"second", like.second},
                             {"rel_mse", like.rel_mse},
                             {"framing",
                              {{"right", like.framing.right},
                               {"down", like.framing.down},
                               {"larger", like.framing.larger}}},
                             {"blocks",
                              {{"median", like.blocks.median},
                               {"most", like.blocks.most},
                               {"x", like.blocks.x},
                               {"y", like.blocks.y}}}};
    fmt::print("{}\n", out.dump());
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "peer_compare: {}\n", error.what());
    return 2;
  }
}
