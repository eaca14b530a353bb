// Each hostile file of the corpus gives an error that names the place: tests/data/fuzz/refusals.txt
// says which.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "common/assets/bundle.hpp"
#include "common/base/json.hpp"
#include "common/image/picture.hpp"
#include "common/image/texels_decode.hpp"
#include "common/image/tile.hpp"
#include "common/job/job_spec.hpp"
#include "common/scene/gltf/draco.hpp"
#include "common/scene/obj.hpp"
#include "common/scene/ply.hpp"
#include "common/scene/scene_file.hpp"
#include "common/wire/codec.hpp"
#include "common/wire/framing.hpp"
#include "tests/fuzz/target.hpp"

namespace tessera {
namespace {

namespace fs = std::filesystem;

fs::path corpus() {
  const char* const folder = std::getenv("TESSERA_SOURCE_DIR");
  return (folder != nullptr ? fs::path(folder) : fs::current_path()) / "tests/data/fuzz";
}

std::string content_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  EXPECT_TRUE(in) << file;
  return {std::istreambuf_iterator<char>(in), {}};
}

/// A scene file, with all the files that the corpus may name beside it.
void load(const fs::path& file, const std::string& name) {
  const fs::path obj = corpus() / "obj/square.obj";
  const scene::BundleFiles files({{name, file},
                                  {"data.bin", obj},
                                  {"a.png", obj},
                                  {"a.obj", obj},
                                  {"a.ply", corpus() / "ply/ascii.ply"},
                                  {"a.gltf", corpus() / "gltf/triangle-data-uri.gltf"}});
  (void)scene::load_scene(files, name);
}

void read_frames(const std::string& text) {
  const std::span<const std::byte> bytes = std::as_bytes(std::span(text)).subspan(1);
  wire::FrameReader reader;
  if ((static_cast<unsigned char>(text[0]) & 128U) != 0) reader.welcomed();
  for (std::span<const std::byte> rest = bytes; !rest.empty();) (void)reader.read(rest);
  if (reader.in_message()) throw Error(ErrorKind::bad_input, "waits for the rest");
}

image::TileExpectation expected_tile() {
  return {.window = {.x = 8, .y = 4, .width = 4, .height = 3},
          .film_width = 40,
          .film_height = 30,
          .samples = 3,
          .aovs = false};
}

using Read = std::function<void(const fs::path&, const std::string&)>;

template <class Decoder>
Read by(const Decoder& decoder) {
  return [&decoder](const fs::path& file, const std::string& text) {
    (void)decoder(std::as_bytes(std::span(text)), {file.filename().string()});
  };
}

const std::map<std::string, Read>& readers() {
  using Path = const fs::path&;
  using Text = const std::string&;
  static const std::map<std::string, Read> table{
      {"scene_json", [](Path file, Text) { load(file, "scene.json"); }},
      {"gltf", [](Path file, Text) { load(file, "model.glb"); }},
      {"draco",
       [](Path, Text text) {
         (void)scene::gltf::decode_draco(std::as_bytes(std::span(text)),
                                         std::span<const scene::gltf::DracoAttribute>());
       }},
      {"obj", [](Path, Text text) { (void)scene::parse_obj(text, "mesh.obj"); }},
      {"ply", [](Path, Text text) { (void)scene::parse_ply(text, "mesh.ply"); }},
      {"png", by(image::decode_png)},
      {"jpeg", by(image::decode_jpeg)},
      {"webp", by(image::decode_webp)},
      {"tga", by(image::decode_tga)},
      {"hdr", by(image::decode_hdr)},
      {"exr", by(image::decode_exr)},
      {"picture", by(image::read_exr)},
      {"tile",
       [](Path, Text text) {
         (void)image::decode_tile(std::as_bytes(std::span(text)), expected_tile());
       }},
      {"frames", [](Path, Text text) { read_frames(text); }},
      {"messages",
       [](Path, Text text) {
         (void)wire::decode(static_cast<unsigned char>(text[0]), std::string_view(text).substr(1));
       }},
      {"bundle", [](Path, Text text) { (void)assets::bundle_from_json(text); }},
      {"job", [](Path, Text text) { (void)job_spec_from_json(parse_json(text, "job")); }}};
  return table;
}

/// "target/file: words of its error", a line each.
std::map<std::string, std::string> refusals() {
  std::map<std::string, std::string> out;
  std::ifstream in(corpus() / "refusals.txt");
  for (std::string line; std::getline(in, line);) {
    const std::size_t colon = line.find(": ");
    out[line.substr(0, colon)] = colon == std::string::npos ? "" : line.substr(colon + 2);
  }
  return out;
}

TEST(Refusals, every_hostile_file_gives_an_error_that_names_the_place) {
  const std::map<std::string, std::string> expected = refusals();
  std::set<std::string> seen;
  for (const auto& [target, read] : readers())
    for (const auto& entry : fs::directory_iterator(corpus() / target)) {
      const std::string name = entry.path().filename().string();
      if (!name.starts_with("bad-")) continue;
      const std::string key = target + "/" + name;
      seen.insert(key);
      try {
        read(entry.path(), content_of(entry.path()));
        ADD_FAILURE() << key << " is taken";
      } catch (const Error& error) {
        const auto words = expected.find(key);
        EXPECT_TRUE(words != expected.end() && !words->second.empty() &&
                    std::string(error.what()).find(words->second) != std::string::npos)
            << key << ": " << error.what();
      }
    }
  for (const auto& [key, words] : expected) EXPECT_TRUE(seen.contains(key)) << key;
}

TEST(Refusals, all_other_files_of_the_corpus_that_stand_for_good_ones_are_taken) {
  for (const auto& [target, read] : readers())
    for (const auto& entry : fs::directory_iterator(corpus() / target)) {
      const std::string name = entry.path().filename().string();
      if (name.starts_with("bad-") || name.starts_with("found-")) continue;
      if (target == "tile" && name.starts_with("aovs")) continue;  // another task's
      EXPECT_NO_THROW(read(entry.path(), content_of(entry.path()))) << target << "/" << name;
    }
}

}  // namespace
}  // namespace tessera
