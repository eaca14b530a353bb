#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "common/base/error.hpp"
#include "common/job/matte.hpp"
#include "tests/render/support.hpp"
#include "worker/scene/build.hpp"

/// Outputs beside the picture.
namespace tessera::render::proof {
namespace {

/// One channel's value in the middle of what a camera sees that looks at one point.
struct Seen {
  image::TileImage image;

  [[nodiscard]] float at(std::string_view channel) const {
    const int index = image.layout->index_of(channel);
    EXPECT_GE(index, 0) << channel;
    return index < 0 ? 0 : image.plane(static_cast<std::size_t>(index))[0];
  }
};

Seen look(const SceneMaker& maker, std::vector<std::string> aovs, bool follow_specular = false) {
  TaskRequest request = request_of({.side = 1, .samples = 4, .bounces = 8}, 1);
  request.settings.aovs = std::move(aovs);
  request.settings.aovs_follow_specular = follow_specular;
  tbb::task_arena arena(1);
  std::optional<RenderedTask> done = render_task(maker.build(), request, arena);
  return {std::move(done.value().image)};
}

TEST(Aov, PositionIsWhereTheFirstSurfaceIsInTheWorld) {
  SceneMaker maker;
  maker.add(maker.diffuse(0.5), scene::Quad{{90, 80, -7}, {20, 0, 0}, {0, 20, 0}});
  maker.look({100, 90, 3}, {100, 90, -7});
  const Seen seen = look(maker, {"P"});
  EXPECT_EQ(seen.image.layout->index_of("albedo.R"), -1);
  EXPECT_NEAR(seen.at("P.X"), 100, 1e-3);
  EXPECT_NEAR(seen.at("P.Y"), 90, 1e-3);
  EXPECT_NEAR(seen.at("P.Z"), -7, 1e-3);
}

/// A mirror at 45 degrees, in which the camera sees a wall of albedo 0.25 whose normal is along x.
SceneMaker mirror_before_a_wall() {
  SceneMaker maker;
  maker.add(maker.mirror(0.5), scene::Quad{{-1, -1, 1}, {2, 0, -2}, {0, 2, 0}});
  maker.add(maker.diffuse(0.25), scene::Quad{{5, -5, -5}, {0, 0, 10}, {0, 10, 0}});
  maker.look({0, 0, 5}, {0, 0, 0}, 0.001, {0, 1, 0});
  return maker;
}

TEST(Aov, AlbedoAndNormalAreTheMirrorsUnlessTheyFollowIt) {
  const SceneMaker maker = mirror_before_a_wall();
  const Seen own = look(maker, {});
  EXPECT_NEAR(own.at("albedo.R"), 0.5, 1e-6);
  EXPECT_NEAR(std::abs(own.at("N.X")), std::sqrt(0.5), 1e-5);
  const Seen followed = look(maker, {}, true);
  EXPECT_NEAR(followed.at("albedo.R"), 0.125, 1e-6);
  EXPECT_NEAR(std::abs(followed.at("N.X")), 1, 1e-5);
  EXPECT_EQ(followed.at("Z"), own.at("Z"));
  for (const std::size_t c : {image::R, image::M2_R, image::A})
    EXPECT_EQ(followed.image.plane(c)[0], own.image.plane(c)[0]);
}

TEST(Aov, ThatIsNotAskedForChangesNoBitOfThePicture) {
  const SceneMaker maker = mirror_before_a_wall();
  const Seen usual = look(maker, {});
  const Seen other = look(maker, {"P", "UV", "object_id", "CryptoMaterial", "time"});
  for (std::size_t c = 0; c <= image::M2_B; ++c)
    EXPECT_EQ(usual.image.plane(c)[0], other.image.plane(c)[0]) << c;
}

TEST(Aov, UvIsTheSurfacesOwnAlsoWhereNoMaterialWantsIt) {
  SceneMaker maker;
  maker.add(maker.diffuse(0.5), scene::Quad{{-1, -1, 0}, {2, 0, 0}, {0, 2, 0}});
  maker.look({0.5, -0.5, 5}, {0.5, -0.5, 0});
  const Seen quad = look(maker, {"UV"});
  EXPECT_NEAR(quad.at("UV.U"), 0.75, 1e-4);
  EXPECT_NEAR(quad.at("UV.V"), 0.75, 1e-4);

  scene::Mesh bare;
  bare.positions = {{-9, -1, 0}, {-7, -1, 0}, {-7, 1, 0}};
  bare.triangles = {{0, 1, 2}};
  scene::Mesh mapped = bare;
  for (auto& position : mapped.positions) position[0] += 4;
  mapped.uvs = {{0, 4}, {2, 4}, {2, 8}};
  maker.add(0, bare).add(0, mapped);
  maker.look({-4, -0.5, 5}, {-4, -0.5, 0});
  const Seen mesh = look(maker, {"UV"});
  EXPECT_NEAR(mesh.at("UV.U"), 1, 1e-4);
  EXPECT_NEAR(mesh.at("UV.V"), 5, 1e-4);
  maker.look({-8, -0.5, 5}, {-8, -0.5, 0});
  EXPECT_EQ(look(maker, {"UV"}).at("UV.U"), 0);
}

TEST(Aov, IsRefusedByASceneThatWasBuiltWithoutWhatItLooksAt) {
  SceneMaker maker;
  maker.add(maker.diffuse(0.5), scene::Quad{{-1, -1, 0}, {2, 0, 0}, {0, 2, 0}});
  TaskRequest plain = request_of({.side = 1}, 1), with_uv = plain;
  plain.settings.aovs = {"P", "N"};
  with_uv.settings.aovs = {"P", "UV"};
  const auto built_for = [&](const TaskRequest& request) {
    return worker::build_scene(scene::Scene(maker.description), accel::Device(), {},
                               needs_of(request.settings));
  };
  const Scene bare = built_for(plain), whole = built_for(with_uv);
  EXPECT_NO_THROW(check_request(whole, with_uv));
  EXPECT_NO_THROW(check_request(whole, plain));
  EXPECT_NO_THROW(check_request(bare, plain));
  try {
    check_request(bare, with_uv);
    FAIL() << "it was taken";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::failed);
    EXPECT_STREQ(error.what(), "the scene was built without what the job's AOVs look at");
  }
}

TEST(Aov, ASceneThatIsBuiltForMoreShowsTheSame) {
  SceneMaker maker;
  const std::uint32_t gray = maker.diffuse(0.5);
  scene::Mesh mapped = ball(1, true);
  for (const auto& p : mapped.positions) mapped.uvs.push_back({p[0], p[1]});
  maker.add(gray, std::move(mapped)).add(gray, ball(1, false), translate(1.5, 0, 0));
  maker.environment(1).look({0, 0.5, 6}, {0.5, 0, 0}, 25);
  const TaskRequest request = request_of({.side = 16, .samples = 4, .bounces = 3}, 1);
  const auto built = [&](bool coordinates) {
    tbb::task_arena arena(1);
    const Scene scene = worker::build_scene(scene::Scene(maker.description), accel::Device(), {},
                                            {.coordinates = coordinates});
    return render_task(scene, request, arena)->image.values;
  };
  EXPECT_EQ(built(false), built(true));
}

/// Ids with their shares of the samples, as the slots have them.
std::map<float, float> matte(const Seen& seen, const std::string& layer) {
  std::map<float, float> out;
  for (std::size_t slot = 0; slot < matte_slots; ++slot) {
    const std::string channels = layer + "0" + std::to_string(slot / 2) + '.';
    const float id = seen.at(channels + "RB"[slot % 2]);
    if (id != 0) out[id] = seen.at(channels + "GA"[slot % 2]);
  }
  return out;
}

/// Of what the camera sees, a wall fills the upper left quarter and a floor the upper right one.
SceneMaker an_edge() {
  SceneMaker maker;
  const std::uint32_t grey = maker.diffuse(0.5), white = maker.diffuse(0.8);
  maker.add(grey, scene::Quad{{-1, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  maker.add(white, scene::Quad{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  maker.description.shapes[0].name = "wall";
  maker.description.shapes[1].name = "floor";
  maker.look({0, 0, 5}, {0, 0, 0}, 0.1, {0, 1, 0});
  return maker;
}

TEST(Matte, OfAnEdgeShowsBothObjectsByTheirShares) {
  const Seen seen = look(an_edge(), {"CryptoObject", "CryptoMaterial", "object_id"});
  const std::map<float, float> objects = matte(seen, "CryptoObject");
  const std::map<float, float> expected{{matte_id("wall"), 1.0F}, {matte_id("floor"), 1.0F}};
  EXPECT_EQ(objects, expected);  // of four stratified samples
  EXPECT_EQ(matte(seen, "CryptoMaterial"),
            (std::map<float, float>{{matte_id("m0"), 1.0F}, {matte_id("m1"), 1.0F}}));
  EXPECT_EQ(seen.at("evicted.CryptoObject"), 0);
  EXPECT_EQ(seen.at("A"), 0.5F);
  const float id = seen.at("object_id");
  EXPECT_TRUE(id == 0 || id == 1 || id == 2) << id;
}

TEST(Ids, AreThoseOfTheLowestSampleIndex) {
  const SceneMaker maker = an_edge();
  const Scene scene = maker.build();
  tbb::task_arena arena(1);
  const auto ids_of = [&](SampleRange samples) {
    TaskRequest request = request_of({.side = 5, .samples = 1}, 1);
    request.settings.aovs = {"object_id", "material_id"};
    request.samples = samples;
    const image::TileImage image = render_task(scene, request, arena).value().image;
    EXPECT_EQ(image.layout->index_of("object_id"), 7);
    return std::vector<float>(image.values.begin() + 7 * 25, image.values.end());
  };
  const std::vector<float> first = ids_of({0, 1}), second = ids_of({1, 1});
  EXPECT_EQ(ids_of({0, 9}), first);
  EXPECT_EQ(ids_of({1, 4}), second);
  EXPECT_NE(first, second);
  EXPECT_EQ(*std::max_element(first.begin(), first.end()), 2);
}

/// An object of two shapes, one of them an ellipsoid, placed twice, and one that is placed once.
SceneMaker instances() {
  SceneMaker maker;
  const std::uint32_t grey = maker.diffuse(0.5);
  scene::Scene& scene = maker.description;
  maker.add(grey, scene::Quad{{-1, -1, 0}, {2, 0, 0}, {0, 2, 0}});
  maker.add(grey, scene::Sphere{{0, 0, 3}, 1}, scale(1, 0.5, 1));
  scene.objects = {{"pawn", std::move(scene.shapes)}, {"king", {}}};
  scene.objects[1].shapes.push_back(scene.objects[0].shapes[0]);
  scene.shapes.clear();
  maker.add(grey, scene::Sphere{{0, 30, 0}, 1}, scale(1, 1, 0.5));
  scene.shapes[0].name = "egg";
  const std::uint32_t left = scene.instance_names.add("left"),
                      middle = scene.instance_names.add("middle");
  scene.instances = {{0, translate(-10, 0, 0), {}, left},
                     {0, translate(10, 0, 0), {}},
                     {1, translate(0, -30, 0), {}, middle}};
  return maker;
}

TEST(Matte, NamesInstancesAsTheSceneDoes) {
  SceneMaker maker = instances();
  struct Look {
    scene::Vec3 at;
    const char* name;
    float number;
  };
  for (const Look& one : {Look{{0, 30, 0}, "egg", 1}, Look{{-10.9, 0.9, 0}, "left", 2},
                          Look{{-10, 0, 1}, "left", 2}, Look{{10.9, 0.9, 0}, "pawn", 3},
                          Look{{10, 0, 1}, "pawn", 3}, Look{{0, -30, 0}, "middle", 4}}) {
    maker.look({one.at[0], one.at[1], 50}, one.at);
    const Seen seen = look(maker, {"CryptoObject", "object_id", "material_id"});
    EXPECT_EQ(matte(seen, "CryptoObject"), (std::map<float, float>{{matte_id(one.name), 4.0F}}))
        << one.name;
    EXPECT_EQ(seen.at("object_id"), one.number) << one.name;
    EXPECT_EQ(seen.at("material_id"), 1);
  }
  maker.look({100, 0, 50}, {100, 0, 0});
  const Seen nothing = look(maker, {"CryptoObject", "object_id"});
  EXPECT_TRUE(matte(nothing, "CryptoObject").empty());
  EXPECT_EQ(nothing.at("object_id"), 0);
}

TEST(Time, OfThePixelsIsThatOfTheTaskAndTravelsWithEveryPass) {
  TaskRequest request = request_of({.side = 16, .samples = 16, .bounces = 4}, 1);
  request.settings.aovs = {"time"};
  request.aovs = false;
  tbb::task_arena arena(2);
  const RenderedTask done = render_task(mirror_before_a_wall().build(), request, arena).value();
  ASSERT_EQ(done.image.channels(), 8U);
  const std::span<const float> seconds = done.image.plane(7);
  EXPECT_GT(*std::min_element(seconds.begin(), seconds.end()), 0);
  const double all = std::accumulate(seconds.begin(), seconds.end(), 0.0);
  EXPECT_LE(all, done.stats.cpu_seconds * (1 + 1e-6));
}

}  // namespace
}  // namespace tessera::render::proof
