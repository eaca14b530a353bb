#include "client/job_options.hpp"

#include <gtest/gtest.h>

#include "tests/unit/client/support.hpp"

namespace tessera::client {
namespace {

scene::Scene scene_of() {
  scene::Scene scene;
  scene.name = "Ball";
  scene.cameras = {{.name = "left"}, {.name = "right"}};
  scene.render.width = 40;
  scene.render.height = 30;
  scene.render.samples = 9;
  scene.render.seed = 5;
  scene.render.filter = "tent";
  return scene;
}

TEST(JobOptions, what_is_not_given_is_the_scenes) {
  const JobSpec spec = job_from(scene_of(), {}, digest_of("bundle"));
  EXPECT_EQ(spec.name, "Ball");
  EXPECT_EQ(spec.bundle, digest_of("bundle"));
  EXPECT_EQ(spec.render, scene_of().render);
  EXPECT_EQ(spec.camera, "");
  EXPECT_EQ(spec.tile, JobSpec{}.tile);
  EXPECT_EQ(spec.frames, FrameList{});
}

TEST(JobOptions, a_scene_that_catches_shadows_is_given_the_aov_that_they_travel_in) {
  scene::Scene scene = scene_of();
  const auto aovs_of = [&](const JobOptions& options) {
    return job_from(scene, options, Digest{}).render.aovs;
  };
  using Names = std::vector<std::string>;
  scene.shapes.emplace_back();
  EXPECT_EQ(aovs_of({}), Names{});
  scene.shapes.back().visibility.shadow_catcher = true;
  EXPECT_EQ(aovs_of({}), (Names{"albedo", "N", "Z", "shadow_catcher"}));
  JobOptions options;
  options.aovs = Names{"P"};
  EXPECT_EQ(aovs_of(options), (Names{"P", "shadow_catcher"}));
}

TEST(JobOptions, who_ends_shadow_catchers_by_their_noise_is_told_that_it_is_not_measured) {
  scene::Scene scene = scene_of();
  scene.shapes.emplace_back();
  const auto notes_of = [&](const JobOptions& options) {
    std::vector<std::string> notes;
    job_from(scene, options, Digest{}, &notes);
    return notes;
  };
  JobOptions by_noise;
  by_noise.noise_threshold = 0.01;
  EXPECT_TRUE(notes_of(by_noise).empty());
  scene.shapes.back().visibility.shadow_catcher = true;
  EXPECT_TRUE(notes_of({}).empty());
  ASSERT_EQ(notes_of(by_noise).size(), 1U);
  EXPECT_EQ(notes_of(by_noise)[0].find("--noise does not measure"), 0U);
}

TEST(JobOptions, a_crop_lies_within_the_film_and_a_focus_within_the_crop) {
  const auto refused_at = [](const JobOptions& options) {
    try {
      job_from(scene_of(), options, Digest{});
    } catch (const Error& error) {
      return error.place().key;
    }
    return std::string();
  };
  JobOptions options;
  options.crop = Rect{5, 5, 10, 10};
  options.pixel_aspect = 2;
  const JobSpec spec = job_from(scene_of(), options, Digest{});
  EXPECT_EQ(spec.render.window(), (Rect{5, 5, 10, 10}));
  EXPECT_EQ(spec.render.pixel_aspect, 2);
  options.focus = Rect{4, 5, 2, 2};
  EXPECT_EQ(refused_at(options), "--focus");
  options.focus.reset();
  options.crop->x = 100'000;
  EXPECT_EQ(refused_at(options), "--crop");
  options.crop.reset();
  options.pixel_aspect = 0;
  EXPECT_EQ(refused_at(options), "--pixel-aspect");
}

TEST(JobOptions, a_focus_is_a_geometry) {
  EXPECT_EQ(rect_from("256x128+640+300", "--focus"), (Rect{640, 300, 256, 128}));
  EXPECT_EQ(rect_from("640,300,256,128", "--crop"), (Rect{640, 300, 256, 128}));
  for (const char* wrong :
       {"", "1,2,3", "1,2,3,4,", "1,2+3,4", "256x128", "256x128+640", "256x128-1+3", "1x1+2+3+4",
        "ax1+2+3", "99999999999x1+0+0", "1x1++2+3", " 1x1+2+3", "none"})
    EXPECT_THROW(rect_from(wrong, "--focus"), Error) << wrong;
  JobOptions options;
  options.focus = rect_from("2x2+39+0", "--focus");
  try {
    job_from(scene_of(), options, Digest{});
    ADD_FAILURE() << "it is not within the film";
  } catch (const Error& error) {
    EXPECT_EQ(error.place().key, "--focus");
  }
}

TEST(JobOptions, a_time_is_seconds_or_units) {
  EXPECT_EQ(time_from("90"), 90);
  EXPECT_EQ(time_from("90s"), 90);
  EXPECT_EQ(time_from("10m"), 600);
  EXPECT_EQ(time_from("1h30m"), 5400);
  EXPECT_EQ(time_from("2d1h1m1s"), 176461);
  for (const char* wrong :
       {"", "0", "m", "1.5h", "30m1h", "1m1m", "10 m", "-5", "10x", "1h30", "99999999999"})
    EXPECT_THROW(time_from(wrong), Error) << wrong;
}

TEST(JobOptions, an_order_has_a_name) {
  JobOptions options;
  options.order = "center";
  EXPECT_EQ(job_from(scene_of(), options, Digest{}).order, TileOrder::center);
  options.order = "centre";
  try {
    job_from(scene_of(), options, Digest{});
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.place().key, "--order");
    EXPECT_NE(error.message().find("did you mean \"center\""), std::string::npos);
  }
}

TEST(JobOptions, a_camera_may_be_named_by_its_number) {
  JobOptions options;
  options.camera = "1";
  EXPECT_EQ(job_from(scene_of(), options, Digest{}).camera, "right");
  scene::Scene scene = scene_of();
  scene.cameras[0].name = "1";
  EXPECT_EQ(job_from(scene, options, Digest{}).camera, "1") << "a name comes before a number";
}

TEST(JobOptions, what_is_given_wins) {
  JobOptions options;
  options.name = "Mine";
  options.camera = "right";
  options.width = 250;
  options.height = 131;
  options.samples = 100;
  options.bounces = 0;
  options.sampler = "independent";
  options.filter = "box";
  options.filter_width = 2;
  options.light_samples = 4;
  options.seed = 77;
  options.aovs = {"P", "light_default"};
  options.aovs_follow_specular = true;
  options.aov_samples = 64;
  options.tile = 23;
  options.pass = 12;
  options.priority = -3;
  options.max_workers = 6;
  options.time_limit_seconds = 90;
  options.focus = Rect{1, 2, 3, 4};
  options.mixed = true;
  const JobSpec spec = job_from(scene_of(), options, Digest{});
  EXPECT_EQ(spec.name, "Mine");
  EXPECT_EQ(spec.camera, "right");
  EXPECT_EQ(spec.render.width, 250);
  EXPECT_EQ(spec.max_workers, 6);
  EXPECT_EQ(spec.time_limit_seconds, 90);
  EXPECT_EQ(spec.focus, (Rect{1, 2, 3, 4}));
  EXPECT_EQ(spec.render.height, 131);
  EXPECT_EQ(spec.render.samples, 100);
  EXPECT_EQ(spec.render.bounces, 0);
  EXPECT_EQ(spec.render.sampler, "independent");
  EXPECT_EQ(spec.render.filter, "box");
  EXPECT_EQ(spec.render.filter_width, 2);
  EXPECT_EQ(spec.render.light_samples, 4);
  EXPECT_EQ(spec.render.seed, 77U);
  EXPECT_EQ(spec.render.aovs, (std::vector<std::string>{"P", "light_default"}));
  EXPECT_TRUE(spec.render.aovs_follow_specular);
  EXPECT_EQ(spec.aov_samples, 64);
  EXPECT_EQ(spec.tile, 23);
  EXPECT_EQ(spec.pass, 12);
  EXPECT_EQ(spec.priority, -3);
  EXPECT_TRUE(spec.mixed);
}

TEST(JobOptions, a_scene_without_a_name_lends_the_job_its_files) {
  scene::Scene scene = scene_of();
  scene.name.clear();
  JobOptions options;
  options.scene = "a/b/shot-12.json";
  EXPECT_EQ(job_from(scene, options, Digest{}).name, "shot-12");
}

void expect_refused(const std::function<void(JobOptions&)>& change, const std::string& key,
                    const std::string& part) {
  JobOptions options;
  change(options);
  const Error error = error_of([&] { (void)job_from(scene_of(), options, Digest{}); });
  EXPECT_EQ(error.kind(), ErrorKind::bad_input);
  EXPECT_EQ(error.place().key, key);
  EXPECT_NE(error.message().find(part), std::string::npos) << error.what();
}

TEST(JobOptions, mistakes_name_the_flag_and_the_nearest_name) {
  expect_refused([](JobOptions& o) { o.camera = "2"; }, "--camera", "left, right");
  expect_refused([](JobOptions& o) { o.camera = "rigth"; }, "--camera", "did you mean \"right\"?");
  expect_refused([](JobOptions& o) { o.filter = "tenf"; }, "--filter", "did you mean \"tent\"?");
  expect_refused([](JobOptions& o) { o.integrator = "paht"; }, "--integrator",
                 "did you mean \"path\"?");
  expect_refused([](JobOptions& o) { o.sampler = "halton"; }, "--sampler",
                 "expected one of: sobol_owen, sobol, independent, pcg, xorshift, mt19937");
  expect_refused([](JobOptions& o) { o.samples = 1'000'000'000; }, "--samples",
                 "from 1 to 16777216, found 1000000000");
  expect_refused([](JobOptions& o) { o.samples = 0; }, "--samples", "found 0");
  expect_refused([](JobOptions& o) { o.width = 0; }, "--size", "found 0");
  expect_refused([](JobOptions& o) { o.width = o.height = 1'000'000; }, "--size",
                 "from 1 to 65536");
  expect_refused([](JobOptions& o) { o.tile = 513; }, "--tile", "from 1 to 512");
  expect_refused([](JobOptions& o) { o.light_samples = 0; }, "--light-samples", "found 0");
  expect_refused([](JobOptions& o) { o.bounces = -1; }, "--bounces", "found -1");
  expect_refused([](JobOptions& o) { o.aovs = {"Zz"}; }, "--aovs", "did you mean \"Z\"?");
  expect_refused([](JobOptions& o) { o.aovs = {"light_key"}; }, "--aovs",
                 "expected one of: light_default");
  expect_refused([](JobOptions& o) { o.priority = 101; }, "--priority", "found 101");
}

scene::Scene chair_of_wood() {
  scene::Scene scene = scene_of();
  scene.materials.resize(1);
  scene.materials[0].name = "wood";
  scene.shapes.resize(2);
  scene.shapes[0].name = scene.shapes[1].name = "chair";
  return scene;
}

TEST(JobOptions, a_job_carries_the_names_for_the_manifests_of_its_cryptomattes_alone) {
  const scene::Scene scene = chair_of_wood();
  const auto names = [&](const std::vector<std::string>& aovs) {
    JobOptions options;
    options.aovs = aovs;
    return job_from(scene, options, Digest{}).cryptomatte;
  };
  EXPECT_TRUE(names({}).empty());
  EXPECT_TRUE(names({"N", "object_id"}).empty());
  EXPECT_EQ(names({"CryptoObject"}), (MatteNames{.objects = {"chair"}, .materials = {}}));
  EXPECT_EQ(names({"CryptoMaterial"}), (MatteNames{.objects = {}, .materials = {"wood"}}));
  EXPECT_EQ(names({"CryptoMaterial", "CryptoObject"}),
            (MatteNames{.objects = {"chair"}, .materials = {"wood"}}));
}

TEST(JobOptions, names_that_are_too_many_for_a_job_are_left_out_with_a_note) {
  scene::Scene scene = chair_of_wood();
  JobOptions options;
  options.aovs = {"CryptoObject", "CryptoMaterial"};
  std::vector<std::string> notes;
  job_from(scene, options, Digest{}, &notes);
  EXPECT_TRUE(notes.empty());
  scene.shapes[1].name = std::string(200'000, 'x');
  const JobSpec spec = job_from(scene, options, Digest{}, &notes);
  EXPECT_EQ(spec.cryptomatte, (MatteNames{.objects = {}, .materials = {"wood"}}));
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_NE(notes[0].find("CryptoObject comes without a manifest"), std::string::npos) << notes[0];
  options.aovs = {"CryptoMaterial"};
  notes.clear();
  job_from(scene, options, Digest{}, &notes);
  EXPECT_TRUE(notes.empty()) << "no object's name is asked for";
}

TEST(Size, is_read_whole_or_not_at_all) {
  EXPECT_EQ(size_from("1920x1080"), (Size{1920, 1080}));
  for (const char* text : {"", "1920", "1920x", "x1080", "1920X1080", "1920x1080 ", " 1920x1080",
                           "1920x1080x3", "99999999999x1", "axb"})
    EXPECT_EQ(error_of([&] { (void)size_from(text); }).place().key, "--size") << text;
}

}  // namespace
}  // namespace tessera::client
