#include "tests/unit/scene/support.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

namespace tessera::scene {

namespace fs = std::filesystem;

fs::path source_folder() {
  const char* const folder = std::getenv("TESSERA_SOURCE_DIR");
  return folder != nullptr ? fs::path(folder) : fs::current_path();
}

std::string text_of_file(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  EXPECT_TRUE(in) << file;
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

Scene parse(std::string_view text) { return parse_scene(text, "test.json", BundleFiles({})); }

std::string scene_with(std::string_view members) {
  return "{" + std::string(members) +
         "\n\"tessera\": 1, \"camera\": {\"eye\": [0, 0, 5], \"target\": [0, 0, 0]}}";
}

Error error_of(std::string_view text) {
  try {
    (void)parse(text);
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "no error for " << text.substr(0, 200);
  return Error(ErrorKind::failed, "none");
}

}  // namespace tessera::scene
