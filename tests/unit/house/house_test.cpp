// The house's rules, proved from its sources: includes run one way only, each outside library has
// one room, no circles. And from the programs built: what they link, and that the worker's
// arithmetic is the sources'.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

/// Folder → folders whose headers it may include, besides its own.
const std::map<std::string, std::set<std::string>>& allowed() {
  static const std::map<std::string, std::set<std::string>> table{
      {"common/base", {}},
      {"common/job", {"common/base"}},
      {"common/image", {"common/base", "common/job"}},
      {"common/wire", {"common/base", "common/job"}},
      {"common/net", {"common/base", "common/wire", "common/job"}},
      {"common/assets", {"common/base"}},
      {"common/scene", {"common/base", "common/job"}},
      {"server/schedule", {"common/base", "common/job"}},
      {"server/film", {"common/base", "common/job", "common/image"}},
      {"server/store", {"common/base", "common/job"}},
      {"server/coordinator",
       {"common/base", "common/job", "common/image", "common/wire", "common/assets",
        "server/schedule", "server/film", "server/store"}},
      {"server/session",
       {"common/base", "common/job", "common/wire", "common/net", "server/schedule",
        "server/coordinator"}},
      {"server/http",
       {"common/base", "common/job", "common/net", "common/assets", "server/schedule",
        "server/coordinator"}},
      {"server",
       {"common/base", "common/net", "common/assets", "server/coordinator", "server/session",
        "server/http"}},
      {"worker/accel", {"common/base"}},
      {"worker/render",
       {"common/base", "common/job", "common/image", "common/scene", "worker/accel"}},
      {"worker/scene",
       {"common/base", "common/job", "common/image", "common/scene", "worker/accel",
        "worker/render"}},
      {"worker/agent",
       {"common/base", "common/job", "common/image", "common/wire", "common/net", "common/assets",
        "common/scene", "worker/render", "worker/scene"}},
      {"worker", {"common/base", "common/net", "worker/agent", "worker/scene", "worker/render"}},
      {"client",
       {"common/base", "common/job", "common/image", "common/net", "common/assets",
        "common/scene"}},
      {"scenes", {"common/base", "common/image"}},
  };
  return table;
}

/// What includes an outside library → the one folder where that may stand.
const std::vector<std::pair<std::regex, std::string>>& rooms() {
  static const std::vector<std::pair<std::regex, std::string>> table{
      {std::regex("^(OpenEXR/|Imf|Iex|Imath|openexr)"), "common/image"},
      {std::regex("^embree[34]/"), "worker/accel"},
      {std::regex("^(sqlite3\\.h|SQLiteCpp/)"), "server/store"},
      {std::regex("^spdlog/"), "common/base"},
      {std::regex("^(tiny_gltf\\.h|meshoptimizer\\.h|draco/|tiny_obj_loader\\.h)"), "common/scene"},
      {std::regex("^stb/stb_truetype"), "client"},
      {std::regex("^(stb/stb_image|png\\.h|jpeglib\\.h|webp/)"), "common/image"},
  };
  return table;
}

fs::path root() {
  const char* folder = std::getenv("TESSERA_SOURCE_DIR");
  return folder != nullptr ? fs::path(folder) : fs::current_path();
}

struct Include {
  std::string file, folder, name;
  int line;
};

/// "worker/render/bsdf/x.hpp" → "worker/render"; "server/main.cpp" → "server".
std::string folder_of(const std::string& path) {
  const std::size_t first = path.find('/');
  const std::string top = path.substr(0, first);
  if (top == "client" || top == "scenes") return top;
  const std::size_t second = path.find('/', first + 1);
  return second == std::string::npos ? top : path.substr(0, second);
}

std::vector<Include> all_includes() {
  static const std::regex form(R"(^\s*#\s*include\s*[<"]([^>"]+)[>"])");
  std::vector<Include> found;
  for (const char* top : {"common", "server", "worker", "client", "scenes"}) {
    for (const auto& entry : fs::recursive_directory_iterator(root() / top)) {
      const std::string extension = entry.path().extension().string();
      if (extension != ".hpp" && extension != ".cpp" && extension != ".h") continue;
      const std::string file = fs::relative(entry.path(), root()).generic_string();
      std::ifstream in(entry.path());
      int number = 0;
      for (std::string line; std::getline(in, line);) {
        ++number;
        std::smatch match;
        if (std::regex_search(line, match, form))
          found.push_back({file, folder_of(file), match[1].str(), number});
      }
    }
  }
  return found;
}

bool is_ours(const std::string& name) {
  return std::regex_search(name, std::regex("^(common|server|worker|client|scenes|tests)/"));
}

TEST(House, includes_run_one_way_only) {
  const auto includes = all_includes();
  ASSERT_GT(includes.size(), 300U) << "the sources were not found";
  for (const Include& include : includes) {
    if (!is_ours(include.name)) continue;
    const std::string to = folder_of(include.name);
    if (to == include.folder) continue;
    const auto rule = allowed().find(include.folder);
    ASSERT_NE(rule, allowed().end()) << include.folder << " has no rule; add one";
    EXPECT_TRUE(rule->second.contains(to)) << include.file << ":" << include.line << ": "
                                           << include.folder << " may not include " << to;
  }
}

TEST(House, the_rules_have_no_circle) {
  std::map<std::string, int> state;  // 1: on the way, 2: done
  std::function<void(const std::string&)> visit = [&](const std::string& folder) {
    if (state[folder] == 2) return;
    ASSERT_NE(state[folder], 1) << "a circle through " << folder;
    state[folder] = 1;
    for (const std::string& next : allowed().at(folder)) visit(next);
    state[folder] = 2;
  };
  for (const auto& [folder, others] : allowed()) visit(folder);
}

TEST(House, each_outside_library_has_one_room) {
  for (const Include& include : all_includes())
    for (const auto& [form, room] : rooms())
      if (std::regex_search(include.name, form)) {
        EXPECT_EQ(include.folder, room)
            << include.file << ":" << include.line << ": " << include.name;
      }
}

/// What a command prints; empty where it fails.
std::string printed_by(const std::string& command) {
  std::string out;
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return {};
  std::array<char, 4096> piece{};
  while (std::fgets(piece.data(), static_cast<int>(piece.size()), pipe) != nullptr)
    out += piece.data();
  return pclose(pipe) == 0 ? out : std::string{};
}

/// A built program's path, quoted for the shell.
std::string built(const std::string& program) {
  const char* bin = std::getenv("TESSERA_BIN_DIR");
  return "'" + std::string(bin == nullptr ? "TESSERA_BIN_DIR is not set" : bin) + "/" + program +
         "'";
}

std::string needed_libraries(const std::string& program) {
  return printed_by("ldd " + built(program) + " 2>&1");
}

/// How many of a program's instructions multiply alone, and how many multiply and add at once.
struct Multiplications {
  int plain = 0, contracted = 0;
  bool all_were_read = false;
};

Multiplications multiplications(const std::string& program) {
  const std::string all =
      "(objdump --disassemble --no-show-raw-insn " + built(program) + " && echo END)";
  const std::string text =
      printed_by(all + " | grep --extended-regexp '^END$|vmul[sp][sd]|vfn?m(add|sub)'");
  Multiplications out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    out.all_were_read = line == "END";
    if (!out.all_were_read) ++(line.find("vmul") != std::string::npos ? out.plain : out.contracted);
  }
  return out;
}

/// A product that is rounded only with its sum is another number, so a worker built by another
/// compiler would send other bits. Of the worker that is tested here; tests/bench/run.sh looks at
/// a release's.
TEST(House, no_product_is_contracted_with_its_sum) {
  const Multiplications worker = multiplications("tessera-worker");
  ASSERT_TRUE(worker.all_were_read) << "objdump could not read tessera-worker";
  EXPECT_GT(worker.plain, 1000) << "the test would not see an instruction if it were there";
  EXPECT_EQ(worker.contracted, 0)
      << "find them by: objdump -d tessera-worker | grep -E 'vfn?m(add|sub)'";
}

TEST(House, the_coordinator_links_no_embree) {
  const std::string server = needed_libraries("tessera-server");
  ASSERT_NE(server.find("libsqlite3"), std::string::npos)
      << "could not read what tessera-server links";
  EXPECT_EQ(server.find("embree"), std::string::npos) << server;
  EXPECT_NE(needed_libraries("tessera-worker").find("embree"), std::string::npos)
      << "the test would not see Embree if it were there";
}

TEST(House, each_folder_says_its_subject) {
  for (const auto& [folder, others] : allowed())
    EXPECT_TRUE(fs::exists(root() / folder / "README.md")) << folder << " has no README.md";
}

}  // namespace
