#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <tuple>

#include "tests/unit/scene/support.hpp"

/// Every mistake is an error with its place, what was expected and the nearest name.
namespace tessera::scene {
namespace {

struct Mistake {
  const char* what;
  const char* members;  ///< before the scene's own "tessera" and "camera"
  int line, column;
  const char* key;
  const char* message;  ///< a part of it
};

class Mistakes : public testing::TestWithParam<Mistake> {};

TEST_P(Mistakes, is_refused_at_its_place) {
  const Mistake& mistake = GetParam();
  const Error error = error_of(scene_with(mistake.members));
  EXPECT_EQ(error.kind(), ErrorKind::bad_input);
  EXPECT_EQ(error.place().file, "test.json");
  EXPECT_EQ(error.place().line, mistake.line) << error.what();
  EXPECT_EQ(error.place().column, mistake.column) << error.what();
  EXPECT_EQ(error.place().key, mistake.key);
  EXPECT_NE(error.message().find(mistake.message), std::string::npos) << error.what();
}

constexpr const char* one_shape = R"("materials": {"clay": {"type": "diffuse"}},
"shapes": [)";

std::string shape(const char* text) { return std::string(one_shape) + text + "],"; }

const Mistake whole[] = {
    {"a wrong key", "\n \"shaeps\": [],", 2, 2, "shaeps",
     "unknown key \"shaeps\"; did you mean \"shapes\"?"},
    {"a wrong key within", "\n\"film\": {\"width\": 1,\n  \"hieght\": 2},", 2, 9, "film.height",
     "is required, and is not there"},
    {"a key too many", "\n\"film\": {\"width\": 1,\"height\": 1,\n  \"hight\": 2},", 3, 3,
     "film.hight", "did you mean \"height\"?"},
    {"a doubled key", "\"name\": \"a\",\n\"name\": \"b\",", 2, 1, "",
     "the key \"name\" stands twice"},
    {"a zero-size film", "\"film\": {\"width\": 0, \"height\": 9},", 1, 20, "film.width",
     "a whole number from 1 to 65536, found 0"},
    {"a film of a million by a million", "\"film\": {\"width\": 1000000, \"height\": 1000000},", 1,
     20, "film.width", "from 1 to 65536, found 1000000"},
    {"a film of too many pixels", "\"film\": {\"width\": 65536, \"height\": 65536},", 1, 10, "film",
     "more than the 536870912 pixels"},
    {"half a pixel", "\"film\": {\"width\": 2.5, \"height\": 9},", 1, 20, "film.width",
     "a whole number from 1 to 65536, found 2.5"},
    {"a film that is no object", "\"film\": [1, 2],", 1, 10, "film",
     "expected an object, found a list of 2"},
    {"a billion samples", "\"render\": {\"samples\": 1000000000},", 1, 24, "render.samples",
     "from 1 to 16777216, found 1000000000"},
    {"no samples", "\"render\": {\"samples\": 0},", 1, 24, "render.samples", "from 1 to 16777216"},
    {"an unknown integrator", "\"render\": {\"integrator\": \"pth\"},", 1, 27, "render.integrator",
     "did you mean \"path\"?"},
    {"an unknown sampler", "\"render\": {\"sampler\": \"sobol_own\"},", 1, 24, "render.sampler",
     "unknown sampler \"sobol_own\""},
    {"an unknown filter", "\"render\": {\"filter\": \"boxx\"},", 1, 23, "render.filter",
     "did you mean \"box\"?"},
    {"a crop beyond the film", "\"render\": {\"crop\": [500, 0, 13, 1]},", 1, 21, "render.crop",
     "within the film of 512 by 512"},
    {"a negative seed", "\"render\": {\"seed\": -1},", 1, 21, "render.seed",
     "a whole number from 0"},
    {"an unknown material type", "\"materials\": {\"a\": {\"type\": \"difuse\"}},", 1, 30,
     "materials.a.type",
     "unknown material type \"difuse\"; did you mean \"diffuse\"? (expected one of: diffuse, "
     "mirror, dielectric, emitter, conductor, principled, mix)"},
    {"an unknown metal", "\"materials\": {\"a\": {\"type\": \"conductor\", \"name\": \"golt\"}},",
     1, 51, "materials.a.name",
     "unknown metal \"golt\"; did you mean \"gold\"? (expected one of: gold, copper, aluminium, "
     "silver, iron, chromium)"},
    {"a metal by name and by index",
     "\"materials\": {\"a\": {\"type\": \"conductor\", \"name\": \"gold\", \"k\": 1}},", 1, 51,
     "materials.a.name", "and not both"},
    {"a conductor without k", "\"materials\": {\"a\": {\"type\": \"conductor\", \"eta\": 1}},", 1,
     21, "materials.a.k", "is required"},
    {"attenuation without a distance",
     "\"materials\": {\"a\": {\"type\": \"dielectric\", \"attenuation_color\": 0.5}},", 1, 21,
     "materials.a", "give attenuation_color and attenuation_distance together"},
    {"attenuation within a thin wall",
     "\"materials\": {\"a\": {\"type\": \"principled\", \"attenuation_color\": 0.5, "
     "\"attenuation_distance\": 2}},",
     1, 94, "materials.a.attenuation_distance", "has no inside"},
    {"an opacity above 1", "\"materials\": {\"a\": {\"type\": \"mirror\", \"opacity\": 2}},", 1, 51,
     "materials.a.opacity", "a number from 0 to 1"},
    {"a mix of one", "\"materials\": {\"a\": {\"type\": \"mix\", \"materials\": [\"a\"]}},", 1, 50,
     "materials.a.materials", "expected a list of two materials, found a list of 1"},
    {"a mix of a mix",
     "\"materials\": {\"b\": {\"type\": \"diffuse\"}, \"a\": {\"type\": \"mix\", \"materials\": "
     "[\"b\", \"a\"]}},",
     1, 82, "materials.a.materials[1]", "a mix cannot be part of a mix"},
    {"a mix of nothing known",
     "\"materials\": {\"bone\": {\"type\": \"diffuse\"}, \"a\": {\"type\": \"mix\", \"materials\": "
     "[\"bone\", \"bon\"]}},",
     1, 88, "materials.a.materials[1]", "did you mean \"bone\"?"},
    {"a mix of a lamp",
     "\"materials\": {\"b\": {\"type\": \"emitter\", \"radiance\": 1}, \"a\": {\"type\": \"mix\", "
     "\"materials\": [\"b\", \"b\"]}},",
     1, 92, "materials.a.materials[0]", "what emits cannot be part of a mix"},
    {"a mix of what is unlit",
     "\"materials\": {\"b\": {\"type\": \"principled\", \"unlit\": true}, \"a\": {\"type\": "
     "\"mix\", \"materials\": [\"b\", \"b\"]}},",
     1, 95, "materials.a.materials[0]", "what is unlit cannot be part of a mix"},
    {"a back that glass lacks",
     "\"materials\": {\"a\": {\"type\": \"dielectric\", \"back_culled\": true}},", 1, 59,
     "materials.a.back_culled", "a back from which it leaves"},
    {"a back that glass in a mix lacks",
     "\"materials\": {\"g\": {\"type\": \"dielectric\"}, \"d\": {\"type\": \"diffuse\"}, \"a\": "
     "{\"type\": \"mix\", \"materials\": [\"d\", \"g\"], \"back_culled\": true}},",
     1, 132, "materials.a.back_culled", "a back from which it leaves"},
    {"a mix of what may not be there",
     "\"materials\": {\"b\": {\"type\": \"diffuse\", \"opacity\": 1}, \"a\": {\"type\": \"mix\", "
     "\"materials\": [\"b\", \"b\"]}},",
     1, 91, "materials.a.materials[0]", "belong to the mix"},
    {"a reflectance above 1",
     "\"materials\": {\"a\": {\"type\": \"diffuse\", \"reflectance\": [0, 1.5, 0]}},", 1, 60,
     "materials.a.reflectance[1]", "a number from 0 to 1, found 1.5"},
    {"a colour of two", "\"materials\": {\"a\": {\"type\": \"diffuse\", \"reflectance\": [0, 1]}},",
     1, 56, "materials.a.reflectance", "a list of 3 numbers, found a list of 2"},
    {"a colour by name",
     "\"materials\": {\"a\": {\"type\": \"diffuse\", \"reflectance\": \"red\"}},", 1, 56,
     "materials.a.reflectance", "expected a colour"},
    {"another type's key", "\"materials\": {\"a\": {\"type\": \"mirror\", \"ior\": 2}},", 1, 40,
     "materials.a.ior", "unknown key \"ior\""},
    {"a negative radiance", "\"environment\": {\"radiance\": -1},", 1, 30, "environment.radiance",
     "a number from 0"},
    {"an object without shapes", "\"objects\": {\"a\": {\"shapes\": []}},", 1, 30,
     "objects.a.shapes", "at least one shape"},
    {"an unknown object",
     "\"materials\": {\"m\": {\"type\": \"mirror\"}}, \"objects\": {\"tree\": {\"shapes\": "
     "[{\"type\": \"sphere\", "
     "\"material\": \"m\"}]}},\n\"instances\": [{\"object\": \"tre\"}],",
     2, 26, "instances[0].object", "did you mean \"tree\"?"},
    {"an object of none", "\"instances\": [{\"object\": \"tre\"}],", 1, 27, "instances[0].object",
     "the scene has none"},
    {"two cameras' keys", "\"cameras\": [],", 1, 13, "cameras",
     "give camera, or the list cameras, and not both"},
};
INSTANTIATE_TEST_SUITE_P(Whole, Mistakes, testing::ValuesIn(whole));

struct ShapeMistake {
  const char* text;
  int column;  ///< of line 2, where `"shapes": [` takes 11
  const char* key;
  const char* message;
};
class ShapeMistakes : public testing::TestWithParam<ShapeMistake> {};

TEST_P(ShapeMistakes, is_refused_at_its_place) {
  const ShapeMistake& mistake = GetParam();
  const Error error = error_of(scene_with(shape(mistake.text)));
  EXPECT_EQ(error.kind(), ErrorKind::bad_input);
  EXPECT_EQ(error.place().line, 2) << error.what();
  EXPECT_EQ(error.place().column, mistake.column + 11) << error.what();
  EXPECT_EQ(error.place().key, std::string("shapes[0]") + mistake.key);
  EXPECT_NE(error.message().find(mistake.message), std::string::npos) << error.what();
}

const ShapeMistake shapes[] = {
    {R"({"type": "spere", "material": "clay"})", 10, ".type",
     "unknown shape type \"spere\"; did you mean \"sphere\"? (expected one of: quad, disk, "
     "sphere, box, mesh)"},
    {R"({"type": "disk", "material": "clay", "normal": [0, 0, 0]})", 48, ".normal",
     "a normal needs a length"},
    {R"({"type": "sphere"})", 1, ".material", "is required, and is not there"},
    {R"({"type": "sphere", "material": "cly"})", 32, ".material",
     "unknown material \"cly\"; did you mean \"clay\"?"},
    {R"({"type": "sphere", "material": "clay", "radius": 0})", 50, ".radius",
     "a number from 1e-08"},
    {R"({"type": "sphere", "material": "clay", "radius": true})", 50, ".radius", "found true"},
    {R"({"type": "sphere", "material": "clay", "center": [0, 0, 1e300]})", 57, ".center[2]",
     "to 1000000000000, found 1e+300"},
    {R"({"type": "sphere", "material": "clay", "center": [0, [0, 0], 0]})", 54, ".center[1]",
     "found a list of 2"},
    {R"({"type": "box", "material": "clay", "low": [0, 0, 0], "high": [1, 0, 1]})", 63, ".high",
     "along axis y"},
    {R"({"type": "quad", "material": "clay", "corner": [0, 0, 0], "edge_u": [1, 2, 3], "edge_v": [2, 4, 6]})",
     1, "", "the quad has no area"},
    {R"({"type": "quad", "material": "clay", "corner": [0, 0, 0], "edge_u": [1e-10, 0, 0], "edge_v": [0, 1e-10, 0]})",
     1, "", "the quad is too small"},
    {R"({"type": "box", "material": "clay", "low": [0, 0, 0], "high": [1e-10, 1e-10, 1e-10]})", 63,
     ".high", "the box is too small"},
    {R"({"type": "sphere", "material": "clay", "transform": [{"scale": 0}]})", 53, ".transform",
     "singular"},
    {R"({"type": "sphere", "material": "clay", "transform": [{"scale": [1, 0, 1]}]})", 53,
     ".transform", "singular"},
    {R"({"type": "sphere", "material": "clay", "transform": [{"matrix": [1,0,0,0, 2,0,0,0, 0,0,1,0]}]})",
     53, ".transform", "singular"},
    {R"({"type": "sphere", "material": "clay", "transform": [{"matrix": [1, 2]}]})", 65,
     ".transform[0].matrix", "12 numbers"},
    {R"({"type": "sphere", "material": "clay", "transform": [{"matrix": [1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,2]}]})",
     65, ".transform[0].matrix", "the last row"},
    {R"({"type": "sphere", "material": "clay", "transform": [{"tanslate": [1, 0, 0]}]})", 55,
     ".transform[0].tanslate", "did you mean \"translate\"?"},
    {R"({"type": "sphere", "material": "clay", "transform": [{"scale": 1, "translate": [1, 0, 0]}]})",
     54, ".transform[0]", "found 2 keys"},
    {R"({"type": "sphere", "material": "clay", "transform": {"scale": 1}})", 53, ".transform",
     "expected a list of steps"},
    {R"({"type": "sphere", "material": "clay", "transform": [{"rotate": {"axis": [0, 0, 0], "degrees": 1}}]})",
     74, ".transform[0].rotate.axis", "an axis needs a length"},
    {R"({"type": "sphere", "material": "clay", "transform": [{"translate": ["NaN", 0, 0]}]})", 69,
     ".transform[0].translate[0]", "found \"NaN\""},
    {R"({"type": "sphere", "material": "clay", "transform": [{"scale": 1e9}, {"scale": 1e9}]})", 53,
     ".transform", "entries beyond"},
    {R"({"type": "mesh", "material": "clay", "positions": [[0,0,0],[1,0,0],[0,1,0]], "triangles": [[0, 1, 3]]})",
     99, ".triangles[0][2]", "index 3 is out of range: there are 3 positions, the last is 2"},
    {R"({"type": "mesh", "material": "clay", "positions": [[0,0,0],[1,0,0],[0,1,0]], "triangles": [[0, -1, 2]]})",
     96, ".triangles[0][1]", "a whole number from 0"},
    {R"({"type": "mesh", "material": "clay", "positions": [[0,0,0],[1,0,0],[0,1,0]], "triangles": [[0, 1]]})",
     92, ".triangles[0]", "3 indices"},
    {R"({"type": "mesh", "material": "clay", "positions": [[0,0,0],[1,0,0],[0,1,0]], "triangles": []})",
     91, ".triangles", "at least one triangle"},
    {R"({"type": "mesh", "material": "clay", "positions": [[0,0,0],[1,0,0],[0,1]], "triangles": [[0, 1, 2]]})",
     68, ".positions[2]", "a list of 3 numbers"},
    {R"({"type": "mesh", "material": "clay", "positions": [[0,0,0],[1,0,0],[0,1,0]], "normals": [[0,0,1]], "triangles": [[0, 1, 2]]})",
     89, ".normals", "as many as positions, 3, found 1"},
    {R"({"type": "mesh", "material": "clay", "positions": [[0,0,0],[1,0,0],[0,1,0]], "normals": [[0,0,1],[0,0,0],[0,0,1]], "triangles": [[0, 1, 2]]})",
     98, ".normals[1]", "a normal needs a length"},
    {R"({"type": "mesh", "material": "clay", "positions": [[0,0,0],[1,0,0],[0,1,0]], "normals": [[0,0,1],[0,0,1],[0,1e-50,0]], "triangles": [[0, 1, 2]]})",
     106, ".normals[2]", "a normal needs a length"},
    {R"({"type": "mesh", "material": "clay", "file": "a.obj", "positions": []})", 68, ".positions",
     "exclude each other"},
    {R"({"type": "mesh", "material": "clay", "file": "missing.obj"})", 46, ".file",
     "no file \"missing.obj\" in the bundle"},
    {R"({"type": "mesh", "material": "clay", "file": "../secret.obj"})", 46, ".file",
     "leads outside"},
    {R"({"type": "mesh", "material": "clay", "file": "/etc/passwd"})", 46, ".file",
     "is an absolute path"},
};
INSTANTIATE_TEST_SUITE_P(Shapes, ShapeMistakes, testing::ValuesIn(shapes));

struct CameraMistake {
  const char* camera;
  const char* key;
  const char* message;
};
class CameraMistakes : public testing::TestWithParam<CameraMistake> {};

TEST_P(CameraMistakes, is_refused) {
  const Error error = error_of(std::string("{\"tessera\": 1, ") + GetParam().camera + "}");
  EXPECT_EQ(error.place().key, GetParam().key);
  EXPECT_NE(error.message().find(GetParam().message), std::string::npos) << error.what();
}

const CameraMistake cameras[] = {
    {R"("name": "x")", "camera", "is required"},
    {R"("cameras": [])", "cameras", "at least one camera"},
    {R"("camera": {"eye": [0, 0, 0], "target": [0, 0, 0]})", "camera.target", "looks nowhere"},
    {R"("camera": {"eye": [0, 0, 0], "target": [0, 5, 0]})", "camera", "along the line of sight"},
    {R"("camera": {"eye": [0, 0, 0], "target": [1, 0, 0], "up": [-2, 0, 0]})", "camera.up",
     "along the line of sight"},
    {R"("camera": {"eye": [0, 0, 0], "target": [1, 0, 0], "up": [0, 0, 0]})", "camera.up",
     "no length"},
    {R"("camera": {"eye": [0, 0, 0], "target": [1, 0, 0], "fov": 180})", "camera.fov",
     "a number from 0.001 to 179.999"},
    {R"("camera": {"eye": [0, 0, 0], "target": [1, 0, 0], "fov": 40, "focal_length": 1})",
     "camera.fov", "not by both"},
    {R"("camera": {"eye": [0, 0, 0], "target": [1, 0, 0], "focal_length": 1})", "camera.film_size",
     "is required"},
    {R"("cameras": [{"name": "a", "eye": [0, 0, 0], "target": [1, 0, 0]}, {"name": "a", "eye": [0, 0, 0], "target": [1, 0, 0]}])",
     "cameras[1]", "two cameras have the name \"a\""},
};
INSTANTIATE_TEST_SUITE_P(Cameras, CameraMistakes, testing::ValuesIn(cameras));

TEST(Errors, a_sphere_that_emits_may_not_become_an_ellipsoid) {
  const std::string lamp = R"("materials": {"lamp": {"type": "emitter", "radiance": 1}},)";
  const std::string ball = R"({"type": "sphere", "name": "sun", "material": "lamp")";
  const Error alone = error_of(scene_with(lamp + "\n\"shapes\": [" + ball +
                                          ",\n\"transform\": [{\"scale\": [1, 2, 1]}]}],"));
  EXPECT_EQ(alone.kind(), ErrorKind::bad_input);
  EXPECT_EQ(alone.place().line, 3);
  EXPECT_EQ(alone.place().column, 14);
  EXPECT_EQ(alone.place().key, "shapes[0].transform");
  EXPECT_NE(alone.message().find("the sphere \"sun\" emits and would become an ellipsoid"),
            std::string::npos);

  const std::string object = lamp + R"("objects": {"it": {"shapes": [)" + ball + "}]}},\n";
  const Error placed = error_of(scene_with(object +
                                           R"("instances": [{"object": "it"},
{"object": "it", "transform": [{"rotate": {"axis": [0, 0, 1], "degrees": 9}}, {"scale": [1, 2, 1]}]}],)"));
  EXPECT_EQ(placed.place().line, 3);
  EXPECT_EQ(placed.place().key, "instances[1].transform");
  EXPECT_NE(placed.message().find("ellipsoid"), std::string::npos);

  EXPECT_NO_THROW(parse(scene_with(
      object +
      R"("instances": [{"object": "it", "transform": [{"scale": [2, 2, -2]}, {"rotate": {"axis": [1, 2, 3], "degrees": 40}}]}],)")));
}

TEST(Errors, transforms_that_together_cannot_be_undone_are_refused_at_the_instance) {
  const auto scene = [](const std::string& instance) {
    return scene_with(R"("materials": {"m": {"type": "diffuse"}},
"objects": {"it": {"shapes": [{"type": "sphere", "name": "dot", "material": "m", "transform": [{"scale": 1e-60}]}]}},
"instances": [{"object": "it"}, {"object": "it", "transform": [{"scale": )" +
                      instance + "}]}],");
  };
  EXPECT_NO_THROW(parse(scene("1e-3")));
  const Error error = error_of(scene("1e-60"));
  EXPECT_EQ(error.kind(), ErrorKind::bad_input);
  EXPECT_EQ(error.place().line, 3);
  EXPECT_EQ(error.place().key, "instances[1].transform");
  EXPECT_NE(error.message().find("\"dot\" together are singular"), std::string::npos)
      << error.what();
}

TEST(Errors, more_materials_than_can_be_told_apart_are_refused_at_the_first_too_many) {
  const auto scene = [](std::size_t count) {
    std::string text = "\"materials\": {";
    for (std::size_t i = 0; i < count; ++i)
      text += (i == 0 ? "\n\"" : ",\n\"") + std::to_string(i) + "\": {\"type\": \"diffuse\"}";
    return scene_with(text + "},");
  };
  EXPECT_EQ(parse(scene(65536)).materials.size(), 65536U);
  const Error error = error_of(scene(65537));
  EXPECT_EQ(error.kind(), ErrorKind::bad_input);
  EXPECT_EQ(error.place().line, 65538);
  EXPECT_EQ(error.place().key, "materials.65536");
  EXPECT_NE(error.message().find("more than 65536 materials"), std::string::npos);
}

TEST(Errors, the_sentence_has_file_line_column_and_key) {
  const Error error = error_of("{\n  \"tessera\": 2}");
  EXPECT_EQ(std::string(error.what()),
            "test.json:2:14: tessera: expected a whole number from 1 to 1, found 2");
}

TEST(Errors, a_root_that_is_no_object_is_refused) {
  EXPECT_EQ(error_of("[]").message(), "expected an object, found a list of 0");
}

TEST(Errors, deep_nesting_and_numbers_beyond_double_are_refused) {
  EXPECT_EQ(error_of(std::string(200'000, '[')).message(), "nested deeper than 64 levels");
  EXPECT_NE(error_of(scene_with("\"environment\": {\"radiance\": 1e400},"))
                .message()
                .find("beyond the range"),
            std::string::npos);
  EXPECT_NE(error_of(scene_with("\"environment\": {\"radiance\": NaN},"))
                .message()
                .find("not valid JSON"),
            std::string::npos);
}

TEST(Errors, any_cut_of_a_good_scene_is_an_error_and_no_crash) {
  const std::string good = text_of_file(source_folder() / "scenes" / "cornell-glass.json");
  ASSERT_NO_THROW(parse(good));
  const std::size_t end = good.find_last_of('}');
  for (std::size_t length = 0; length <= end; length += 7)
    (void)error_of(std::string_view(good).substr(0, length));
}

TEST(Errors, no_changed_byte_of_a_good_scene_makes_a_crash) {
  std::string good = text_of_file(source_folder() / "scenes" / "cornell-glass.json");
  int refused = 0;
  for (std::size_t at = 0; at < good.size(); at += 3) {
    const char before = good[at];
    good[at] = "\"{[}],:0-e\\\x01\xff"[at % 12];
    try {
      (void)parse(good);
    } catch (const Error& error) {
      ++refused;
      EXPECT_GE(error.place().line, 1) << error.what();
    }
    good[at] = before;
  }
  EXPECT_GT(refused, 100);
}

TEST(Names, of_what_mattes_show_are_plain_texts_or_refused_at_their_place) {
  const std::string parts = R"("materials": {"m": {"type": "diffuse"}},
"objects": {"it": {"shapes": [{"type": "sphere", "material": "m"}]}},)";
  for (const std::string& name :
       {std::string(), std::string("a\\u0001"), std::string("a\\nb"), std::string(129, 'x')}) {
    const std::string member = "\n\"name\": \"" + name + "\"";
    for (const auto& [members, key, line] :
         {std::tuple(R"("shapes": [{"type": "sphere", "material": "m",)" + member + "}],",
                     "shapes[0].name", 4),
          std::tuple(R"("instances": [{"object": "it",)" + member + "}],", "instances[0].name", 4),
          std::tuple(R"("include": [{"file": "a.glb",)" + member + "}],", "include[0].name", 4)}) {
      const Error error = error_of(scene_with(parts + '\n' + members));
      EXPECT_EQ(error.place().key, key) << error.what();
      EXPECT_EQ(error.place().line, line) << error.what();
      EXPECT_NE(error.message().find("1 to 128 bytes without control characters"),
                std::string::npos)
          << error.what();
    }
  }
  EXPECT_NO_THROW(parse(scene_with(parts + R"("instances": [{"object": "it", "name": ")" +
                                   std::string(128, 'x') + R"("}],)")));
}

}  // namespace
}  // namespace tessera::scene
