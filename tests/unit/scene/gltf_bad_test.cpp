#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "tests/unit/scene/gltf_file.hpp"

namespace tessera::scene {
namespace {

using testing::HasSubstr;

struct Bad {
  const char* what;
  std::function<void(nlohmann::json&)> spoil;
  const char* place;  ///< JSON pointer
};

/// A file with something of most kinds.
GltfFile rich_file() {
  GltfFile file;
  file.with_triangle();
  file.json["meshes"][0]["primitives"][0]["indices"] = file.indices({0, 1, 2});
  file.json["meshes"][0]["primitives"][0]["material"] = 0;
  file.json["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}};
  file.json["textures"] = {{{"source", 0}}};
  file.json["images"] = {{{"uri", "data:,x"}}};
  file.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}}};
  file.node({{"camera", 0}});
  file.json["nodes"].push_back(nlohmann::json::object());
  return file;
}

TEST(GltfBad, an_error_names_the_file_and_where_in_it) {
  const Bad cases[] = {
      {"no asset", [](auto& j) { j.erase("asset"); }, "/asset"},
      {"glTF 1", [](auto& j) { j["asset"]["version"] = "1.0"; }, "/asset/version"},
      {"a later one", [](auto& j) { j["asset"]["minVersion"] = "2.1"; }, "/asset/minVersion"},
      {"a list that is none", [](auto& j) { j["meshes"] = 3; }, "/meshes"},
      {"an item that is none", [](auto& j) { j["nodes"][1] = "x"; }, "/nodes/1"},
      {"no such scene", [](auto& j) { j["scene"] = 1; }, "/scene"},
      {"no such node", [](auto& j) { j["scenes"][0]["nodes"][0] = 9; }, "/scenes/0/nodes/0"},
      {"no such mesh", [](auto& j) { j["nodes"][0]["mesh"] = 1; }, "/nodes/0/mesh"},
      {"a mesh by name", [](auto& j) { j["nodes"][0]["mesh"] = "a"; }, "/nodes/0/mesh"},
      {"an index with a fraction", [](auto& j) { j["nodes"][0]["mesh"] = 0.0; }, "/nodes/0/mesh"},
      {"an index beyond 32 bits", [](auto& j) { j["nodes"][0]["mesh"] = 4294967296; },
       "/nodes/0/mesh"},
      {"a negative index", [](auto& j) { j["nodes"][0]["mesh"] = -1; }, "/nodes/0/mesh"},
      {"a cycle",
       [](auto& j) {
         j["nodes"][2]["children"] = {2};
         j["nodes"][1]["children"] = {2};
       },
       "/nodes/2/children"},
      {"two parents", [](auto& j) { j["nodes"][1]["children"] = {0}; }, "/nodes/1/children"},
      {"a short matrix",
       [](auto& j) {
         j["nodes"][0]["matrix"] = {1, 2};
       },
       "/nodes/0/matrix"},
      {"a number far too large",
       [](auto& j) {
         j["nodes"][0]["translation"] = {1e300, 0, 0};
       },
       "/nodes/0/translation/0"},
      {"no such accessor",
       [](auto& j) { j["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 7; },
       "/meshes/0/primitives/0/attributes/POSITION"},
      {"positions of two numbers", [](auto& j) { j["accessors"][0]["type"] = "VEC2"; },
       "/meshes/0/primitives/0/attributes/POSITION"},
      {"a count that is hostile", [](auto& j) { j["accessors"][0]["count"] = 4000000000; },
       "/accessors/0/count"},
      {"a count beyond the view", [](auto& j) { j["accessors"][0]["count"] = 4; }, "/accessors/0"},
      {"an offset beyond the view", [](auto& j) { j["accessors"][0]["byteOffset"] = 4; },
       "/accessors/0"},
      {"an offset that overflows",
       [](auto& j) { j["accessors"][0]["byteOffset"] = 18446744073709551615ULL; },
       "/accessors/0/byteOffset"},
      {"a type that does not exist", [](auto& j) { j["accessors"][0]["componentType"] = 5124; },
       "/accessors/0/componentType"},
      {"zeros without end",
       [](auto& j) {
         j["accessors"][0].erase("bufferView");
         j["accessors"][0]["count"] = 1000000000;
       },
       "/accessors/0/count"},
      {"a view beyond its buffer", [](auto& j) { j["bufferViews"][0]["byteLength"] = 1 << 20; },
       "/bufferViews/0"},
      {"a view that begins beyond", [](auto& j) { j["bufferViews"][0]["byteOffset"] = 1 << 20; },
       "/bufferViews/0"},
      {"a stride below the element", [](auto& j) { j["bufferViews"][0]["byteStride"] = 4; },
       "/bufferViews/0/byteStride"},
      {"a buffer longer than the file", [](auto& j) { j["buffers"][0]["byteLength"] = 999; },
       "/buffers/0/byteLength"},
      {"a second buffer without bytes",
       [](auto& j) {
         j["buffers"].push_back({{"byteLength", 4}});
       },
       "/buffers/1"},
      {"an index of no vertex",
       [](auto& j) {
         j["accessors"][1]["componentType"] = 5121, j["accessors"][1]["count"] = 6,
         j["accessors"][0]["count"] = 1;
       },
       "/meshes/0/primitives/0/indices"},
      {"fractions for indices", [](auto& j) { j["meshes"][0]["primitives"][0]["indices"] = 0; },
       "/meshes/0/primitives/0/indices"},
      {"a mode that does not exist", [](auto& j) { j["meshes"][0]["primitives"][0]["mode"] = 7; },
       "/meshes/0/primitives/0/mode"},
      {"a factor beyond 1",
       [](auto& j) { j["materials"][0]["pbrMetallicRoughness"]["metallicFactor"] = 2; },
       "/materials/0/pbrMetallicRoughness/metallicFactor"},
      {"a texture without index",
       [](auto& j) {
         j["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"].erase("index");
       },
       "/materials/0/pbrMetallicRoughness/baseColorTexture/index"},
      {"an extension's number as text",
       [](auto& j) { j["materials"][0]["extensions"]["KHR_materials_ior"]["ior"] = "1.5"; },
       "/materials/0/extensions/KHR_materials_ior/ior"},
      {"no such light",
       [](auto& j) { j["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 0; },
       "/nodes/0/extensions/KHR_lights_punctual/light"},
      {"a camera that sees backwards", [](auto& j) { j["cameras"][0]["perspective"]["yfov"] = 4; },
       "/cameras/0/perspective/yfov"},
      {"a path that leads out", [](auto& j) { j["images"][0]["uri"] = "../secret.png"; },
       "/images/0/uri"},
      {"a path that leads out, in disguise",
       [](auto& j) { j["images"][0]["uri"] = "a/%2e%2e/%2e%2e/secret.png"; }, "/images/0/uri"},
      {"an absolute path", [](auto& j) { j["images"][0]["uri"] = "/etc/hostname"; },
       "/images/0/uri"},
      {"another scheme", [](auto& j) { j["images"][0]["uri"] = "file:///etc/hostname"; },
       "/images/0/uri"},
      {"a file that is not there", [](auto& j) { j["images"][0]["uri"] = "none.png"; },
       "/images/0/uri"},
      {"damaged base64", [](auto& j) { j["images"][0]["uri"] = "data:;base64,a~b"; },
       "/images/0/uri"},
      {"an image of nothing", [](auto& j) { j["images"][0].erase("uri"); }, "/images/0"},
      {"more sparse elements than there are",
       [](auto& j) {
         j["accessors"][0]["sparse"] = {{"count", 9},
                                        {"indices", {{"bufferView", 1}, {"componentType", 5123}}},
                                        {"values", {{"bufferView", 0}}}};
       },
       "/accessors/0/sparse/count"},
      {"a sparse index beyond",
       [](auto& j) {
         j["accessors"][1]["sparse"] = {
             {"count", 2},
             {"indices", {{"bufferView", 0}, {"byteOffset", 14}, {"componentType", 5123}}},
             {"values", {{"bufferView", 1}}}};
       },
       "/accessors/1/sparse/indices"}};
  for (const Bad& bad : cases) {
    GltfFile file = rich_file();
    bad.spoil(file.json);
    const Error error = error_of_bytes(file.glb());
    EXPECT_EQ(error.place().key, bad.place) << bad.what << ": " << error.what();
    EXPECT_TRUE(error.kind() == ErrorKind::bad_input || error.kind() == ErrorKind::too_large)
        << bad.what;
    EXPECT_THAT(error.place().file, HasSubstr("model.glb")) << bad.what;
  }
}

TEST(GltfBad, numbers_that_are_not_finite_are_refused) {
  GltfFile file;
  const int positions =
      file.floats({0, 0, 0, 1, 0, 0, 0, std::numeric_limits<float>::quiet_NaN(), 0}, "VEC3");
  file.node({{"mesh", file.mesh({{"attributes", {{"POSITION", positions}}}})}});
  const Error error = error_of_bytes(file.glb());
  EXPECT_EQ(error.place().key, "/accessors/0");
  EXPECT_THAT(error.message(), HasSubstr("element 2"));
}

TEST(GltfBad, a_glb_cut_off_anywhere_is_refused) {
  const std::string whole = rich_file().glb();
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const TemporaryFolder folder;
    const auto path = folder.write("m.glb", whole.substr(0, size));
    EXPECT_THROW((void)load_scene(path), Error) << size;
  }
}

TEST(GltfBad, chunks_that_do_not_fit_are_refused) {
  std::string other_version = rich_file().glb();
  other_version[4] = 1;
  EXPECT_THAT(error_of_bytes(other_version).message(), HasSubstr("version 1"));
  std::string long_chunk = rich_file().glb();
  long_chunk[15] = 0x7f;
  EXPECT_THAT(error_of_bytes(long_chunk).message(), HasSubstr("ends beyond"));
  std::string no_json = rich_file().glb();
  no_json[16] = 'X';
  EXPECT_THAT(error_of_bytes(no_json).message(), HasSubstr("not JSON"));
}

TEST(GltfBad, nesting_and_long_chains_are_bounded) {
  EXPECT_THAT(error_of_bytes("{\"asset\": " + std::string(100, '[') + std::string(100, ']') + "}",
                             "model.gltf")
                  .message(),
              HasSubstr("nested deeper"));
  GltfFile chain;
  chain.with_triangle();
  for (int i = 0; i < 5000; ++i) {
    nlohmann::json node = nlohmann::json::object();
    if (i + 1 < 5000) node["children"] = {i + 2};
    chain.json["nodes"].push_back(node);
  }
  chain.json["scenes"][0]["nodes"].push_back(1);
  EXPECT_THAT(error_of_bytes(chain.glb()).message(), HasSubstr("nodes above it"));
}

TEST(GltfBad, a_link_that_leads_out_is_refused) {
  const TemporaryFolder folder, elsewhere;
  GltfFile file = rich_file();
  file.json["images"][0]["uri"] = "link.png";
  const auto path = folder.write("m.glb", file.glb());
  std::filesystem::create_symlink(elsewhere.write("x.png", "x"), folder / "link.png");
  try {
    (void)load_scene(path);
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.place().key, "/images/0/uri");
    EXPECT_THAT(error.message(), HasSubstr("leads outside"));
  }
}

TEST(GltfBad, a_damaged_file_gives_an_error_or_a_scene_and_no_crash) {
  const std::string whole = rich_file().glb();
  std::uint64_t state = 1;
  for (int round = 0; round < 1000; ++round) {
    std::string bytes = whole;
    for (int change = 0; change < 3; ++change) {
      state = state * 6364136223846793005ULL + 1442695040888963407ULL;
      bytes[(state >> 33) % bytes.size()] = static_cast<char>(state >> 20);
    }
    const TemporaryFolder folder;
    try {
      (void)load_scene(folder.write("m.glb", bytes));
    } catch (const Error&) {
    }
  }
}

}  // namespace
}  // namespace tessera::scene
