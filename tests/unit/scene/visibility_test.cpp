#include <gmock/gmock.h>

#include "common/scene/shadow_catchers.hpp"
#include "tests/unit/scene/gltf_file.hpp"
#include "tests/unit/scene/support.hpp"

namespace tessera::scene {
namespace {

using testing::HasSubstr;

constexpr const char* clay = R"("materials": {"clay": {"type": "diffuse"}},)";

std::string with_shape(const std::string& members) {
  return scene_with(std::string(clay) + R"("shapes": [{"type": "sphere", "material": "clay", )" +
                    members + "}],");
}

TEST(Visibility, of_a_shape_is_all_unless_said_otherwise) {
  EXPECT_EQ(parse(with_shape(R"("radius": 1)")).shapes.at(0).visibility, Visibility{});
  const auto read = [](const std::string& members) {
    return parse(with_shape("\"visibility\": {" + members + "}")).shapes.at(0).visibility;
  };
  EXPECT_EQ(read(""), Visibility{});
  EXPECT_EQ(read(R"("camera": false)"), (Visibility{.camera = false}));
  EXPECT_EQ(read(R"("shadow": false, "indirect": true)"), (Visibility{.shadow = false}));
  EXPECT_EQ(read(R"("indirect": false, "holdout": true)"),
            (Visibility{.indirect = false, .holdout = true}));
}

TEST(Visibility, of_objects_and_instances_hides_what_their_shapes_do_not) {
  const Scene scene = parse(scene_with(std::string(clay) + R"(
    "objects": {"pair": {"visibility": {"shadow": false}, "shapes": [
      {"type": "sphere", "material": "clay"},
      {"type": "sphere", "material": "clay", "visibility": {"camera": false, "shadow": true}}]}},
    "instances": [{"object": "pair", "visibility": {"holdout": true}}, {"object": "pair"}],)"));
  const std::vector<Shape>& shapes = scene.objects.at(0).shapes;
  EXPECT_EQ(shapes.at(0).visibility, (Visibility{.shadow = false}));
  EXPECT_EQ(shapes.at(1).visibility, (Visibility{.camera = false, .shadow = false}));
  EXPECT_EQ(scene.instances.at(0).visibility, Visibility{.holdout = true});
  EXPECT_EQ(scene.instances.at(1).visibility, Visibility{});
}

TEST(Visibility, of_an_included_file_is_that_of_all_its_shapes) {
  const TemporaryFolder folder;
  GltfFile file;
  file.with_triangle();
  folder.write("one.glb", file.glb());
  folder.write("two.glb", file.glb());
  const Scene scene = load_scene(folder.write("s.json", R"({"tessera": 1, "include": [
    {"file": "one.glb", "visibility": {"camera": false}},
    {"file": "two.glb", "visibility": {"indirect": false}}, "two.glb"]})"))
                          .scene;
  ASSERT_EQ(scene.shapes.size(), 1U);
  EXPECT_EQ(scene.shapes[0].visibility, (Visibility{.camera = false}));
  ASSERT_EQ(scene.instances.size(), 2U);
  EXPECT_EQ(scene.instances[0].visibility, (Visibility{.indirect = false}));
  EXPECT_EQ(scene.instances[1].visibility, Visibility{});
  EXPECT_EQ(scene.objects.at(0).shapes.at(0).visibility, Visibility{});
}

TEST(Visibility, that_is_misspelt_or_no_yes_or_no_is_refused_at_its_place) {
  const Error misspelt = error_of(with_shape(R"("visibility": {"cammera": false})"));
  EXPECT_EQ(misspelt.place().key, "shapes[0].visibility.cammera");
  EXPECT_THAT(misspelt.message(), HasSubstr("did you mean \"camera\"?"));
  const Error number = error_of(with_shape(R"("visibility": {"shadow": 0})"));
  EXPECT_EQ(number.place().key, "shapes[0].visibility.shadow");
  const Error flag = error_of(with_shape(R"("visibility": false)"));
  EXPECT_EQ(flag.place().key, "shapes[0].visibility");
  EXPECT_THAT(flag.message(), HasSubstr("expected an object"));
}

TEST(Film, is_transparent_only_if_it_is_asked_for) {
  EXPECT_FALSE(parse(scene_with("")).film_transparent);
  EXPECT_FALSE(parse(scene_with(R"("film": {"width": 8, "height": 8},)")).film_transparent);
  const auto film = [](const std::string& value) {
    return scene_with(R"("film": {"width": 8, "height": 8, "transparent": )" + value + "},");
  };
  EXPECT_TRUE(parse(film("true")).film_transparent);
  EXPECT_EQ(error_of(film("1")).place().key, "film.transparent");
}

constexpr const char* transparent = R"("film": {"width": 8, "height": 8, "transparent": true},)";

/// A shape with this visibility, on a transparent film.
std::string catching(const std::string& members) {
  return std::string(with_shape("\"visibility\": {" + members + "}")).insert(1, transparent);
}

TEST(ShadowCatchers, are_read_from_shapes_objects_instances_and_included_files) {
  const Scene shape = parse(catching(R"("shadow_catcher": true, "indirect": false)"));
  EXPECT_EQ(shape.shapes.at(0).visibility, (Visibility{.indirect = false, .shadow_catcher = true}));
  EXPECT_TRUE(has_shadow_catchers(shape));
  EXPECT_FALSE(has_shadow_catchers(parse(catching(R"("shadow_catcher": false)"))));
  EXPECT_FALSE(has_shadow_catchers(parse(catching(R"("holdout": true)"))));
  const auto placed = [](const std::string& object, const std::string& instance) {
    return parse(scene_with(std::string(transparent) + clay + R"(
      "objects": {"one": {"visibility": {)" +
                            object + R"(}, "shapes": [
        {"type": "sphere", "material": "clay"}]}},
      "instances": [{"object": "one", "visibility": {)" +
                            instance + "}}],"));
  };
  EXPECT_FALSE(has_shadow_catchers(placed("", "")));
  EXPECT_TRUE(has_shadow_catchers(placed(R"("shadow_catcher": true)", "")));
  EXPECT_TRUE(has_shadow_catchers(placed("", R"("shadow_catcher": true)")));
  const TemporaryFolder folder;
  GltfFile file;
  file.with_triangle();
  folder.write("one.glb", file.glb());
  const auto name = folder.write("s.json", R"({"tessera": 1,
    "film": {"width": 8, "height": 8, "transparent": true},
    "include": [{"file": "one.glb", "visibility": {"shadow_catcher": true}}]})");
  EXPECT_TRUE(has_shadow_catchers(load_scene(name).scene));
  EXPECT_TRUE(has_shadow_catchers(
      survey_scene(FolderFiles(name.parent_path()), name.filename().string()).scene));
}

TEST(ShadowCatchers, that_are_placed_nowhere_catch_nothing) {
  EXPECT_FALSE(has_shadow_catchers(parse(scene_with(std::string(transparent) + clay + R"(
    "objects": {"one": {"visibility": {"shadow_catcher": true}, "shapes": [
      {"type": "sphere", "material": "clay"}]}},)"))));
}

TEST(ShadowCatchers, need_a_transparent_film) {
  for (const char* film : {"", R"("film": {"width": 8, "height": 8},)",
                           R"("film": {"width": 8, "height": 8, "transparent": false},)"}) {
    const Error error =
        error_of(with_shape(R"("visibility": {"shadow_catcher": true})").insert(1, film));
    EXPECT_EQ(error.kind(), ErrorKind::bad_input);
    EXPECT_EQ(error.place().key, "shapes[0].visibility.shadow_catcher");
    EXPECT_EQ(error.message(),
              "what is caught stands in the picture's alpha: expected a film of \"transparent\": "
              "true");
  }
}

TEST(ShadowCatchers, are_no_holdouts) {
  const auto expect_both_refused = [](const Error& error, const std::string& key) {
    EXPECT_EQ(error.place().key, key);
    EXPECT_EQ(error.message(),
              "a holdout catches no shadows: expected \"holdout\" or \"shadow_catcher\", not both");
  };
  expect_both_refused(error_of(catching(R"("holdout": true, "shadow_catcher": true)")),
                      "shapes[0].visibility");
  const auto placed = [](const std::string& shape, const std::string& object,
                         const std::string& instance) {
    return error_of(scene_with(std::string(transparent) + clay + R"(
      "objects": {"one": {"visibility": {)" +
                               object + R"(}, "shapes": [
        {"type": "sphere", "material": "clay", "visibility": {)" +
                               shape + R"(}}]}},
      "instances": [{"object": "one", "visibility": {)" +
                               instance + "}}],"));
  };
  const std::string holdout = R"("holdout": true)", catcher = R"("shadow_catcher": true)";
  expect_both_refused(placed(holdout, catcher, ""), "objects.one");
  expect_both_refused(placed(holdout, "", catcher), "instances[0]");
  expect_both_refused(placed("", catcher, holdout), "instances[0]");
}

TEST(ShadowCatchers, that_are_no_yes_or_no_are_refused_at_their_place) {
  EXPECT_EQ(error_of(catching(R"("shadow_catcher": 1)")).place().key,
            "shapes[0].visibility.shadow_catcher");
  EXPECT_THAT(error_of(catching(R"("shadow_cacher": true)")).message(),
              HasSubstr("did you mean \"shadow_catcher\"?"));
}

}  // namespace
}  // namespace tessera::scene
