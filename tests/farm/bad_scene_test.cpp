// What a person may write wrongly in a scene or on the command line: the client says where and
// what, with exit code 2, before anything is queued; the farm and its other jobs do not notice.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/farm/farm.hpp"

namespace tessera::farm_test {
namespace {

using nlohmann::json;

struct BadScene {
  const char* name;
  std::string text;                    ///< of scene.json
  std::vector<std::string> expected;   ///< each stands in the error
  std::vector<std::string> arguments;  ///< of submit, besides the scene
};

/// A good scene with one part replaced.
std::string scene_with(const std::string& shapes,
                       const std::string& film = R"({"width": 8, "height": 8})",
                       const std::string& more = "", const std::string& materials = "") {
  return "{\n\"tessera\": 1,\n\"film\": " + film +
         ",\n\"camera\": {\"eye\": [0, 0, 5], \"target\": [0, 0, 0], \"fov\": 40},\n" + more +
         "\"materials\": {\"white\": {\"type\": \"diffuse\"}" + materials + "},\n\"shapes\": [\n" +
         shapes + "\n]\n}\n";
}

const char* const sphere = R"({"type": "sphere", "material": "white"})";

std::vector<BadScene> bad_scenes() {
  std::string nested = "{\"tessera\": 1, \"name\": ";
  nested.append(200'000, '[');
  return {
      {"a wrong key",
       scene_with(R"({"type": "sphere", "material": "white", "radus": 2})"),
       {"scene.json:7:", "shapes[0]", "radus", "did you mean \"radius\""},
       {}},
      {"a doubled key",
       scene_with(R"({"type": "sphere", "material": "white", "material": "white"})"),
       {"scene.json:7:", "material", "twice"},
       {}},
      {"200,000 nested brackets", nested, {"scene.json:1:", "deep"}, {}},
      {"a missing mesh",
       scene_with(R"({"type": "mesh", "material": "white", "file": "no-such.obj"})"),
       {"scene.json:7:", "no-such.obj"},
       {}},
      {"a broken OBJ",
       scene_with(R"({"type": "mesh", "material": "white", "file": "broken.obj"})"),
       {"broken.obj"},
       {}},
      {"indices out of range",
       scene_with(
           R"({"type": "mesh", "material": "white", "positions": [[0,0,0],[1,0,0],[0,1,0]], "triangles": [[0,1,7]]})"),
       {"scene.json:7:", "triangles[0]", "7"},
       {}},
      {"a NaN transform",
       scene_with(R"({"type": "sphere", "material": "white", "transform": [{"scale": NaN}]})"),
       {"scene.json:7:"},
       {}},
      {"a transform that overflows",
       scene_with(R"({"type": "sphere", "material": "white", "transform": [{"scale": 1e999}]})"),
       {"scene.json:7:"},
       {}},
      {"a lamp that is an ellipsoid",
       scene_with(R"({"type": "sphere", "material": "lamp", "transform": [{"scale": [1, 2, 1]}]})",
                  R"({"width": 8, "height": 8})", "", R"(,
"lamp": {"type": "emitter", "radiance": 1})"),
       {"scene.json:8:", "shapes[0].transform", "ellipsoid"},
       {}},
      {"an unknown material",
       scene_with(R"({"type": "sphere", "material": "whit"})"),
       {"scene.json:7:", "shapes[0].material", "did you mean \"white\""},
       {}},
      {"a zero-size film",
       scene_with(sphere, R"({"width": 0, "height": 8})"),
       {"scene.json:3:", "film.width", "from 1"},
       {}},
      {"a film of a million by a million",
       scene_with(sphere, R"({"width": 1000000, "height": 1000000})"),
       {"scene.json:3:", "film.width"},
       {}},
      {"10^9 samples",
       scene_with(sphere, R"({"width": 8, "height": 8})",
                  "\"render\": {\"samples\": 1000000000},\n"),
       {"scene.json:5:", "samples", "from 1"},
       {}},
      {"10^9 samples by flag", scene_with(sphere), {"samples"}, {"--samples", "1000000000"}},
      {"a film of a million by a million by flag",
       scene_with(sphere),
       {"size"},
       {"--size", "1000000x1000000"}},
      {"an unknown integrator by flag",
       scene_with(sphere),
       {"did you mean \"path\""},
       {"--integrator", "pth"}},
  };
}

long resident_kib(pid_t pid) {
  std::istringstream status(read_text("/proc/" + std::to_string(pid) + "/status"));
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmRSS:")) return std::stol(line.substr(6));
  return -1;
}

TEST(BadScene, is_refused_with_its_place_and_harms_nothing) {
  Farm farm;
  farm.add_worker();
  const std::string other = farm.submit((sources() / "scenes/cornell.json").string(),
                                        {"--size", "64x64", "--samples", "64"});
  ASSERT_FALSE(other.empty());
  const long before = resident_kib(farm.server().pid());
  ASSERT_GT(before, 0);

  for (const BadScene& bad : bad_scenes()) {
    SCOPED_TRACE(bad.name);
    const TemporaryFolder folder;
    std::ofstream(folder / "scene.json") << bad.text;
    std::ofstream(folder / "broken.obj") << "v 0 0 0\nv 1 0 zero\nv 0 1 0\nf 1 2 9\n";
    std::vector<std::string> arguments{"submit", (folder / "scene.json").string()};
    arguments.insert(arguments.end(), bad.arguments.begin(), bad.arguments.end());
    const Outcome outcome = farm.tessera(arguments, Seconds(20));
    EXPECT_EQ(outcome.code, 2) << outcome.errors;
    EXPECT_EQ(outcome.output, "");
    for (const std::string& text : bad.expected)
      EXPECT_NE(outcome.errors.find(text), std::string::npos)
          << "no \"" << text << "\" in: " << outcome.errors;
    EXPECT_LT(outcome.errors.size(), 2000U) << "an error is a sentence, not a dump";
  }

  EXPECT_TRUE(farm.server().running());
  EXPECT_TRUE(farm.workers()[0].running());
  EXPECT_LT(resident_kib(farm.server().pid()), before + 64 * 1024);
  const json jobs = farm.get("/v1/jobs");
  EXPECT_EQ(jobs.at("jobs").size(), 1U) << "a bad scene was queued: " << jobs.dump(1);
  EXPECT_EQ(farm.finish(other).width, 64);
}

}  // namespace
}  // namespace tessera::farm_test
