#include "client/prepare.hpp"

#include <gtest/gtest.h>

#include "tests/unit/client/support.hpp"

namespace tessera::client {
namespace {

TEST(Prepare, the_bundle_names_the_scene_and_every_file_by_digest_and_size) {
  const TemporaryFolder folder;
  folder.write("meshes/a.obj", small_mesh);
  folder.write("unused.obj", "nothing");
  JobOptions options;
  options.scene = folder.write("ball.json", small_scene);
  const PreparedJob job = prepare(options);
  EXPECT_EQ(job.assets.bundle.scene, "ball.json");
  ASSERT_EQ(job.assets.bundle.files.size(), 2U);
  EXPECT_EQ(job.assets.bundle.files.at("ball.json").digest, digest_of(small_scene));
  EXPECT_EQ(job.assets.bundle.files.at("ball.json").size, small_scene.size());
  EXPECT_EQ(job.assets.bundle.files.at("meshes/a.obj").digest, digest_of(small_mesh));
  EXPECT_EQ(job.spec.bundle, assets::digest_of_bundle(job.assets.bundle));
  EXPECT_EQ(job.spec.render.samples, 9);
}

TEST(Prepare, another_mesh_is_another_bundle) {
  const TemporaryFolder folder;
  folder.write("meshes/a.obj", small_mesh);
  JobOptions options;
  options.scene = folder.write("ball.json", small_scene);
  const Digest before = prepare(options).spec.bundle;
  folder.write("meshes/a.obj", "v 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n");
  EXPECT_NE(prepare(options).spec.bundle, before);
}

TEST(Prepare, by_path_each_file_is_named_where_it_lies_as_its_folder_was_named) {
  const TemporaryFolder folder;
  folder.write("show/meshes/a.obj", small_mesh);
  folder.write("show/ball.json", small_scene);
  std::filesystem::create_directory_symlink(folder / "show", folder / "mnt");
  JobOptions options;
  options.scene = folder / "mnt" / ".." / "mnt" / "ball.json";
  options.by_path = true;
  const PreparedJob job = prepare(options);
  const assets::BundleFile& mesh = job.assets.bundle.files.at("meshes/a.obj");
  EXPECT_EQ(mesh.location, (folder / "mnt" / "meshes" / "a.obj").string());
  EXPECT_EQ(mesh.digest, digest_of(small_mesh));
  EXPECT_TRUE(assets::blobs_of(job.assets.bundle).empty());
}

TEST(Prepare, by_path_what_is_in_memory_alone_goes_over_all_the_same) {
  const TemporaryFolder folder;
  folder.write("meshes/a.obj", small_mesh);
  JobOptions options;
  options.scene = folder.write("ball.json", small_scene);
  options.overrides.environment = "1,1,1";
  options.by_path = true;
  const PreparedJob job = prepare(options);
  EXPECT_EQ(job.assets.bundle.files.at(job.assets.bundle.scene).location, "");
  EXPECT_NE(job.assets.bundle.files.at("meshes/a.obj").location, "");
}

TEST(Prepare, a_scene_that_is_not_there_is_bad_input) {
  JobOptions options;
  options.scene = "/nowhere/ball.json";
  EXPECT_EQ(error_of([&] { (void)prepare(options); }).kind(), ErrorKind::bad_input);
}

TEST(Prepare, a_missing_mesh_is_bad_input_at_its_place) {
  const TemporaryFolder folder;
  JobOptions options;
  options.scene = folder.write("ball.json", small_scene);
  const Error error = error_of([&] { (void)prepare(options); });
  EXPECT_EQ(error.kind(), ErrorKind::bad_input);
  EXPECT_EQ(error.place().key, "shapes[1].file");
  EXPECT_NE(error.message().find("a.obj"), std::string::npos);
}

TEST(Prepare, all_pictures_that_are_none_are_said_before_anything_is_queued) {
  const TemporaryFolder folder;
  folder.write("oak.png", "no picture");
  folder.write("sky.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 1\n\x40\x40\x40\x81");
  JobOptions options;
  options.scene = folder.write("scene.json",
                               R"({"tessera": 1, "camera": {"eye": [0, 0, 5], "target": [0, 0, 0]},
    "environment": {"file": "sky.hdr"},
    "materials": {"m": {"type": "principled", "base_color": {"file": "oak.png"}, "roughness": {"file": "oak.png"}}}})");
  const Error error = error_of([&] { (void)prepare(options); });
  EXPECT_EQ(error.kind(), ErrorKind::bad_input);
  EXPECT_NE(error.message().find("2 files cannot be used"), std::string::npos) << error.message();
  EXPECT_NE(error.message().find("oak.png: not a picture"), std::string::npos) << error.message();
  EXPECT_NE(error.message().find("sky.hdr: "), std::string::npos);
}

TEST(Prepare, all_files_that_are_lacking_or_cannot_be_read_are_said_at_once) {
  const TemporaryFolder folder;
  folder.write("oak.png", "no picture");
  folder.write("bent.obj", "v 0 0\n");
  folder.write("part.gltf",
               R"({"asset": {"version": "2.0"}, "images": [{"uri": "elm.png"}, {"uri": "oak.png"}],
                   "buffers": [{"uri": "part.bin", "byteLength": 4}]})");
  JobOptions options;
  options.scene = folder.write("scene.json",
                               R"({"tessera": 1, "camera": {"eye": [0, 0, 5], "target": [0, 0, 0]},
    "environment": {"file": "sky.hdr"}, "include": ["part.gltf", "none.glb"],
    "materials": {"m": {"type": "principled", "base_color": {"file": "ash.png"}}},
    "shapes": [{"type": "mesh", "material": "m", "file": "bent.obj"},
               {"type": "mesh", "material": "m", "file": "none.ply"}]})");
  const Error error = error_of([&] { (void)prepare(options); });
  EXPECT_EQ(error.kind(), ErrorKind::bad_input);
  EXPECT_NE(error.message().find("8 files cannot be used"), std::string::npos) << error.message();
  for (const char* words :
       {"environment.file: no file", "sky.hdr", "ash.png", "part.gltf: /images/0/uri", "elm.png",
        "part.gltf: /buffers/0/uri", "part.bin", "include[1]", "none.glb", "bent.obj:1", "none.ply",
        "oak.png: not a picture"})
    EXPECT_NE(error.message().find(words), std::string::npos) << words << "\n" << error.message();
}

}  // namespace
}  // namespace tessera::client
