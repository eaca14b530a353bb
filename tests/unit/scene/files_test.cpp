#include <gtest/gtest.h>

#include "tests/unit/scene/support.hpp"

namespace tessera::scene {
namespace {

constexpr const char* triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

std::string scene_of(const std::string& first, const std::string& second) {
  return scene_with(
      "\"materials\": {\"m\": {\"type\": \"diffuse\"}}, \"shapes\": [\n{\"type\": \"mesh\", "
      "\"material\": \"m\", \"file\": \"" +
      first + "\"},\n{\"type\": \"mesh\", \"material\": \"m\", \"file\": \"" + second + "\"}],");
}

Error error_of_file(const std::filesystem::path& file) {
  try {
    (void)load_scene(file);
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "no error";
  return Error(ErrorKind::failed, "none");
}

TEST(Paths, have_one_spelling) {
  EXPECT_EQ(checked_path("a.obj"), "a.obj");
  EXPECT_EQ(checked_path("./a//b/./c.obj"), "a/b/c.obj");
  EXPECT_EQ(checked_path("..a/b..c"), "..a/b..c");
}

TEST(Paths, that_lead_outside_or_name_nothing_are_refused) {
  for (const std::string& path :
       {std::string(), std::string("/a"), std::string(".."), std::string("a/../b"),
        std::string("a/.."), std::string("a\\b"), std::string("a\nb"), std::string("a/"),
        std::string("."), std::string("./"), std::string(2000, 'a'), std::string("a\0b", 3)})
    EXPECT_THROW((void)checked_path(path), Error) << path;
}

TEST(SceneFiles, all_that_a_scene_uses_are_listed_once_the_scene_first) {
  const TemporaryFolder folder;
  folder.write("m/a.obj", triangle);
  const auto file = folder.write("s.json", scene_of("m/a.obj", "./m//a.obj"));
  const LoadedScene loaded = load_scene(file);
  ASSERT_EQ(loaded.files.size(), 2U);
  EXPECT_EQ(loaded.files[0].path, "s.json");
  EXPECT_EQ(loaded.files[1].path, "m/a.obj");
  EXPECT_EQ(text_of_file(loaded.files[1].file), triangle);
  EXPECT_EQ(std::get<Mesh>(loaded.scene.shapes[1].geometry).triangles.size(), 1U);
}

TEST(SceneFiles, the_same_scene_comes_from_a_folder_and_from_a_bundle_of_blobs) {
  const TemporaryFolder folder;
  const auto mesh = folder.write("00ff", triangle);
  const auto text = folder.write("11ee", scene_of("m/a.obj", "m/a.obj"));
  const LoadedScene loaded =
      load_scene(BundleFiles({{"dir/s.json", text}, {"m/a.obj", mesh}}), "dir/s.json");
  EXPECT_EQ(std::get<Mesh>(loaded.scene.shapes[0].geometry).positions.size(), 3U);
}

TEST(SceneFiles, a_missing_mesh_is_an_error_by_name_at_its_place) {
  const TemporaryFolder folder;
  folder.write("a.obj", triangle);
  const auto file = folder.write("s.json", scene_of("a.obj", "b.obj"));
  const Error error = error_of_file(file);
  EXPECT_EQ(error.kind(), ErrorKind::bad_input);
  EXPECT_EQ(error.place().file, file.string());
  EXPECT_EQ(error.place().line, 3);
  EXPECT_EQ(error.place().column, 43);
  EXPECT_EQ(error.place().key, "shapes[1].file");
  EXPECT_EQ(error.message(), "no file \"" + (folder.path() / "b.obj").string() + "\"");
}

TEST(SceneFiles, a_broken_obj_is_an_error_at_its_own_line) {
  const TemporaryFolder folder;
  const auto mesh = folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 one 0\nf 1 2 3\n");
  const Error error = error_of_file(folder.write("s.json", scene_of("a.obj", "a.obj")));
  EXPECT_EQ(error.place().file, mesh.string());
  EXPECT_EQ(error.place().line, 3);
  EXPECT_NE(error.message().find("found \"one\""), std::string::npos) << error.what();
}

TEST(SceneFiles, a_link_that_leads_out_of_the_folder_is_refused_and_one_within_is_not) {
  const TemporaryFolder folder;
  folder.write("outside.obj", triangle);
  folder.write("in/inside.obj", triangle);
  std::filesystem::create_symlink(folder.path() / "outside.obj", folder.path() / "in" / "bad.obj");
  std::filesystem::create_symlink("inside.obj", folder.path() / "in" / "good.obj");
  EXPECT_NO_THROW((void)load_scene(folder.write("in/s.json", scene_of("good.obj", "inside.obj"))));
  const Error error = error_of_file(folder.write("in/t.json", scene_of("good.obj", "bad.obj")));
  EXPECT_NE(error.message().find("a link that leads outside"), std::string::npos);
  EXPECT_EQ(error.place().line, 3);
}

TEST(SceneFiles, a_folder_beside_with_the_same_beginning_is_outside) {
  const TemporaryFolder folder;
  folder.write("in-not/a.obj", triangle);
  folder.write("in/a.obj", triangle);
  std::filesystem::create_symlink(folder.path() / "in-not" / "a.obj",
                                  folder.path() / "in" / "b.obj");
  EXPECT_THROW((void)FolderFiles(folder.path() / "in").locate("b.obj"), Error);
  EXPECT_NO_THROW((void)FolderFiles(folder.path() / "in").locate("a.obj"));
}

TEST(SceneFiles, a_folder_or_a_device_is_no_file) {
  const TemporaryFolder folder;
  folder.write("a.obj/x", "");
  EXPECT_NE(error_of_file(folder.write("s.json", scene_of("a.obj", "a.obj")))
                .message()
                .find("is not a plain file"),
            std::string::npos);
}

TEST(SceneFiles, a_scene_that_is_not_there_is_not_found) {
  EXPECT_EQ(error_of_file("/nowhere/s.json").kind(), ErrorKind::not_found);
  const TemporaryFolder folder;
  EXPECT_EQ(error_of_file(folder.path() / "s.json").kind(), ErrorKind::not_found);
}

TEST(SceneFiles, a_scene_is_found_by_its_bare_name) {
  const TemporaryFolder folder;
  folder.write("s.json", scene_with(""));
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  EXPECT_NO_THROW((void)load_scene("s.json"));
  std::filesystem::current_path(before);
}

}  // namespace
}  // namespace tessera::scene
