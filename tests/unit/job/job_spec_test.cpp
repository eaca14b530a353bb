#include "common/job/job_spec.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "common/base/error.hpp"
#include "common/base/json.hpp"

namespace tessera {
namespace {

using testing::HasSubstr;

JobSpec some_spec() {
  JobSpec spec;
  spec.name = "cornell";
  spec.bundle = digest_of("bundle");
  spec.render.width = 250;
  spec.render.height = 131;
  return spec;
}

/// Key and text of the error, "key: message"; empty if there is none.
std::string refusal(const nlohmann::json& json) {
  try {
    job_spec_from_json(json);
    return {};
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::bad_input);
    return error.what();
  }
}

std::string refusal(const std::function<void(JobSpec&)>& change) {
  JobSpec spec = some_spec();
  change(spec);
  try {
    check(spec);
    return {};
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::bad_input);
    return error.what();
  }
}

TEST(JobSpec, goes_through_JSON_and_comes_back_as_it_was) {
  JobSpec spec = some_spec();
  EXPECT_EQ(job_spec_from_json(to_json(spec)), spec);
  spec.priority = -7;
  spec.camera = "side";
  spec.frames = FrameRange{.first = -3, .last = 9, .step = 4};
  spec.render = {.width = 1,
                 .height = 65536,
                 .samples = 1 << 24,
                 .bounces = 0,
                 .integrator = "i",
                 .sampler = "s",
                 .filter = "f",
                 .filter_width = 2.5,
                 .light_samples = 3,
                 .seed = INT64_MAX,
                 .pixel_aspect = 1.5,
                 .crop = Rect{.x = 0, .y = 65000, .width = 1, .height = 536},
                 .clamp_direct = 5,
                 .clamp_indirect = 0.5,
                 .aovs = {"P", "Z"},
                 .aovs_follow_specular = true};
  spec.tile = 512;
  spec.pass = 1024;
  spec.aov_samples = 64;
  spec.mixed = true;
  spec.max_workers = 9;
  spec.order = TileOrder::center;
  spec.focus = Rect{.x = 0, .y = 65535, .width = 1, .height = 1};
  spec.frames = FrameRange{.first = -3, .last = -3, .step = 4};
  spec.time_limit_seconds = 90.5;
  spec.noise_threshold = 0.02;
  spec.fps = 29.97;
  EXPECT_EQ(job_spec_from_json(parse_json(to_json(spec).dump(), "job")), spec);
}

TEST(JobSpec, refuses_an_order_a_focus_or_a_time_limit_that_cannot_be) {
  EXPECT_THAT(refusal([](JobSpec& spec) {
                spec.focus = Rect{249, 130, 2, 1};
              }),
              HasSubstr("focus.width"));
  EXPECT_EQ(refusal([](JobSpec& spec) { spec.focus = Rect{249, 130, 1, 1}; }), "");
  EXPECT_THAT(refusal([](JobSpec& spec) { spec.time_limit_seconds = -1; }),
              HasSubstr("time_limit_seconds"));
  EXPECT_THAT(refusal([](JobSpec& spec) {
                spec.time_limit_seconds = 1;
                spec.frames = {1, 2, 1};
              }),
              HasSubstr("one frame"));
  nlohmann::json json = to_json(some_spec());
  json["order"] = "hilbret";
  EXPECT_THAT(refusal(json), HasSubstr("did you mean \"hilbert\"?"));
  json = to_json(some_spec());
  json["focus"] = {{"x", 0}, {"y", 0}, {"width", 0}, {"height", 4}};
  EXPECT_THAT(refusal(json), HasSubstr("focus.width"));
}

TEST(JobSpec, refuses_a_crop_beyond_the_film_and_a_focus_beyond_the_crop) {
  EXPECT_EQ(refusal([](JobSpec& spec) { spec.render.crop = Rect{240, 130, 10, 1}; }), "");
  EXPECT_THAT(refusal([](JobSpec& spec) {
                spec.render.crop = Rect{241, 130, 10, 1};
              }),
              HasSubstr("render.crop.width"));
  EXPECT_THAT(refusal([](JobSpec& spec) {
                spec.render.crop = Rect{9, 10, 20, 20};
                spec.focus = Rect{8, 12, 2, 2};
              }),
              HasSubstr("focus.x"));
  EXPECT_THAT(refusal([](JobSpec& spec) { spec.render.pixel_aspect = 0; }),
              HasSubstr("pixel_aspect"));
}

TEST(JobSpec, refuses_a_noise_threshold_that_cannot_be) {
  EXPECT_THAT(refusal([](JobSpec& spec) { spec.noise_threshold = -1; }),
              HasSubstr("noise_threshold"));
  EXPECT_EQ(refusal([](JobSpec& spec) {
              spec.noise_threshold = 0.1;
              spec.frames = {1, 2, 1};
            }),
            "")
      << "each frame ends by its own";
}

TEST(JobSpec, what_is_cropped_and_how_pixels_lie_is_part_of_its_plan_where_it_is_not_the_default) {
  const Digest digest = JobPlan(some_spec()).digest;
  const auto digest_with = [](const std::function<void(RenderSettings&)>& change) {
    JobSpec spec = some_spec();
    change(spec.render);
    return JobPlan(spec).digest;
  };
  EXPECT_NE(digest_with([](RenderSettings& render) { render.pixel_aspect = 2; }), digest);
  EXPECT_NE(digest_with([](RenderSettings& render) { render.crop = Rect{0, 0, 9, 9}; }), digest);
  // Jobs that were accepted before there were these keys have plans without them.
  EXPECT_FALSE(to_json(some_spec())["render"].contains("crop"));
  EXPECT_FALSE(to_json(some_spec())["render"].contains("pixel_aspect"));
  EXPECT_FALSE(to_json(some_spec())["render"].contains("clamp_indirect"));
}

TEST(JobSpec, shows_time_0_at_frame_1_and_as_many_frames_a_second_as_it_says) {
  JobSpec spec = some_spec();
  EXPECT_EQ(time_of(spec, 1), 0);
  EXPECT_EQ(time_of(spec, 25), 1);
  EXPECT_LT(time_of(spec, 0), 0);
  spec.fps = 12;
  EXPECT_EQ(time_of(spec, 25), 2);
  EXPECT_THAT(refusal([](JobSpec& bad) { bad.fps = 0; }), HasSubstr("fps"));
  EXPECT_THAT(refusal([](JobSpec& bad) { bad.fps = std::nan(""); }), HasSubstr("fps"));
}

TEST(JobSpec, frames_a_second_are_part_of_its_plan_where_they_are_not_the_default) {
  JobSpec spec = some_spec();
  const Digest digest = JobPlan(spec).digest;
  spec.fps = 25;
  EXPECT_NE(JobPlan(spec).digest, digest);
  // A job that was accepted before there was the key: the plan is the one that it had.
  nlohmann::json old = to_json(some_spec());
  old.erase("fps");
  EXPECT_EQ(JobPlan(job_spec_from_json(old)).digest, digest);
}

TEST(JobSpec, when_and_by_whom_it_is_rendered_is_no_part_of_its_plan) {
  const Digest digest = JobPlan(some_spec()).digest;
  JobSpec spec = some_spec();
  spec.order = TileOrder::scanline;
  spec.focus = Rect{1, 2, 3, 4};
  spec.time_limit_seconds = 10;
  spec.max_workers = 2;
  EXPECT_EQ(JobPlan(spec).digest, digest);
}

TEST(JobSpec, takes_the_documented_defaults) {
  const nlohmann::json json{
      {"name", "x"}, {"bundle", digest_of("").hex()}, {"render", {{"width", 8}, {"height", 4}}}};
  const JobSpec spec = job_spec_from_json(json);
  EXPECT_EQ(spec.render.samples, 64);
  EXPECT_EQ(spec.render.bounces, 12);
  EXPECT_EQ(spec.render.sampler, "sobol_owen");
  EXPECT_EQ(spec.tile, 64);
  EXPECT_EQ(spec.pass, 256);
  EXPECT_EQ(spec.order, TileOrder::hilbert);
  EXPECT_EQ(spec.focus, std::nullopt);
  EXPECT_EQ(spec.time_limit_seconds, 0);
  EXPECT_EQ(spec.aov_samples, 16);
  EXPECT_EQ(spec.frames.count(), 1U);
  EXPECT_EQ(spec.fps, 24);
  EXPECT_FALSE(spec.mixed);
}

TEST(JobSpec, with_a_bad_value_is_refused_by_its_key) {
  const auto with = [](const char* pointer, const nlohmann::json& value) {
    nlohmann::json json = to_json(some_spec());
    json[nlohmann::json::json_pointer(pointer)] = value;
    return refusal(json);
  };
  EXPECT_EQ(with("/render/width", 0),
            "render.width: expected a whole number from 1 to 65536, found 0");
  EXPECT_EQ(with("/render/height", 1'000'000),
            "render.height: expected a whole number from 1 to 65536, found 1000000");
  EXPECT_EQ(with("/render/samples", 1'000'000'000),
            "render.samples: expected a whole number from 1 to 16777216, found 1000000000");
  EXPECT_EQ(with("/render/samples", 0),
            "render.samples: expected a whole number from 1 to 16777216, found 0");
  EXPECT_EQ(with("/render/bounces", -1),
            "render.bounces: expected a whole number from 0 to 1024, found -1");
  EXPECT_EQ(with("/render/light_samples", 0),
            "render.light_samples: expected a whole number from 1 to 1024, found 0");
  EXPECT_EQ(with("/render/seed", -1),
            "render.seed: expected a whole number from 0 to 9223372036854775807, found -1");
  EXPECT_EQ(with("/render/filter_width", -0.5),
            "render.filter_width: expected a number from 0 to 64, found -0.5");
  EXPECT_EQ(with("/render/filter", ""),
            "render.filter: expected 1 to 128 bytes without control characters");
  EXPECT_EQ(with("/render/sampler", 3), "render.sampler: expected a string, found number");
  EXPECT_EQ(with("/name", "a\nb"), "name: expected 1 to 128 bytes without control characters");
  EXPECT_EQ(with("/priority", 101),
            "priority: expected a whole number from -100 to 100, found 101");
  EXPECT_EQ(with("/bundle", "12"), "bundle: expected a SHA-256 as 64 hexadecimal digits");
  EXPECT_EQ(with("/camera", std::string(257, 'c')), "camera: expected at most 256 bytes of UTF-8");
  EXPECT_EQ(with("/tile", 513), "tile: expected a whole number from 1 to 512, found 513");
  EXPECT_EQ(with("/pass", 1025), "pass: expected a whole number from 1 to 1024, found 1025");
  EXPECT_EQ(with("/aov_samples", 0),
            "aov_samples: expected a whole number from 1 to 16777216, found 0");
  EXPECT_EQ(with("/mixed", "yes"), "mixed: expected true or false, found string");
  EXPECT_EQ(with("/frames/step", 0),
            "frames.step: expected a whole number from 1 to 1000000, found 0");
  EXPECT_EQ(with("/frames/last", 0),
            "frames.last: expected a whole number from 1 to 1000000, found 0");
  EXPECT_THAT(with("/render/widht", 3),
              HasSubstr("render.widht: unknown key \"widht\"; did you mean \"width\"?"));
  EXPECT_THAT(with("/tiles", 3), HasSubstr("tiles: unknown key \"tiles\"; did you mean \"tile\"?"));
}

TEST(JobSpec, without_bundle_name_or_size_is_refused) {
  for (const char* pointer : {"/bundle", "/name", "/render", "/render/width", "/render/height"}) {
    nlohmann::json json = to_json(some_spec());
    const nlohmann::json::json_pointer at(pointer);
    json[at.parent_pointer()].erase(at.back());
    EXPECT_THAT(refusal(json), HasSubstr("is required, and is not there")) << pointer;
  }
}

TEST(JobSpec, of_more_pixels_or_tasks_than_a_job_may_have_is_refused) {
  EXPECT_THAT(refusal([](JobSpec& spec) { spec.render.width = spec.render.height = 65536; }),
              HasSubstr("render.width: a film of 65536 by 65536 has more than the"));
  EXPECT_THAT(refusal([](JobSpec& spec) {
                spec.render.width = spec.render.height = 16384;
                spec.tile = 1;
              }),
              HasSubstr("tile: 268435456 tiles"));
  EXPECT_THAT(
      refusal(
          [](JobSpec& spec) { spec.frames = FrameRange{.first = 0, .last = 999'999, .step = 1}; }),
      HasSubstr("12 tiles, about 6 passes and 1000000 frames are more than the 67108864 tasks"));
}

/// Values that no JSON of ours can hold, but a caller in C++ can.
TEST(JobSpec, that_JSON_could_not_hold_is_refused_all_the_same) {
  EXPECT_THAT(refusal([](JobSpec& spec) { spec.render.seed = 1ULL << 63; }),
              HasSubstr("render.seed: "));
  EXPECT_THAT(refusal([](JobSpec& spec) { spec.render.filter_width = std::nan(""); }),
              HasSubstr("render.filter_width: "));
  EXPECT_THAT(refusal([](JobSpec& spec) {
                spec.frames = FrameRange{.first = INT32_MIN, .last = INT32_MAX, .step = 1};
              }),
              HasSubstr("frames.first: "));
  EXPECT_THAT(
      refusal([](JobSpec& spec) { spec.frames = FrameRange{.first = 2, .last = 1, .step = 1}; }),
      HasSubstr("frames: "));
  EXPECT_THAT(
      refusal([](JobSpec& spec) { spec.frames = FrameRange{.first = 1, .last = 2, .step = 0}; }),
      HasSubstr("frames: "));
  EXPECT_THAT(refusal([](JobSpec& spec) { spec.name = "\xff"; }), HasSubstr("name: "));
  EXPECT_THAT(refusal([](JobSpec& spec) { spec.camera = "\xff"; }), HasSubstr("camera: "));
  EXPECT_THAT(refusal([](JobSpec& spec) { spec.render.samples = 1'000'000'000; }),
              HasSubstr("render.samples: "));
}

TEST(FrameRange, has_every_step_from_first_to_last) {
  const FrameRange frames{.first = -2, .last = 9, .step = 5};
  EXPECT_EQ(frames.count(), 3U);
  for (const int frame : {-2, 3, 8}) EXPECT_TRUE(frames.contains(frame)) << frame;
  for (const int frame : {-7, -1, 4, 9, 13}) EXPECT_FALSE(frames.contains(frame)) << frame;
}

TEST(JobPlan, knows_its_tasks) {
  JobSpec spec = some_spec();
  spec.render.samples = 100;
  spec.frames = FrameRange{.first = 1, .last = 3, .step = 2};
  const JobPlan plan(spec);
  EXPECT_EQ(plan.tasks_per_frame(), 12 * 5);
  EXPECT_EQ(plan.tasks(), 2 * 12 * 5);
  EXPECT_TRUE(plan.contains({.frame = 3, .tile = 11, .pass = 4}));
  EXPECT_FALSE(plan.contains({.frame = 2, .tile = 11, .pass = 4}));
  EXPECT_FALSE(plan.contains({.frame = 3, .tile = 12, .pass = 4}));
  EXPECT_FALSE(plan.contains({.frame = 3, .tile = 11, .pass = 5}));
}

TEST(JobSpec, for_workers_is_the_same_but_for_names_for_manifests_and_the_noise_threshold) {
  JobSpec spec = some_spec();
  spec.cryptomatte.objects = {"floor"};
  spec.noise_threshold = 0.02;
  const JobSpec told = for_workers(spec);
  EXPECT_TRUE(told.cryptomatte.empty());
  EXPECT_EQ(JobPlan(told).digest, JobPlan(spec).digest);
  EXPECT_EQ(told, for_workers(some_spec()));
}

TEST(PlanDigest, covers_all_that_decides_a_task_and_neither_name_nor_priority) {
  const Digest digest = JobPlan(some_spec()).digest;
  const auto changed = [](const std::function<void(JobSpec&)>& change) {
    JobSpec spec = some_spec();
    change(spec);
    return JobPlan(spec).digest;
  };
  EXPECT_EQ(changed([](JobSpec& spec) { spec.name = "other"; }), digest);
  EXPECT_EQ(changed([](JobSpec& spec) { spec.priority = 5; }), digest);
  EXPECT_EQ(changed([](JobSpec& spec) { spec.cryptomatte.objects = {"floor"}; }), digest);
  EXPECT_NE(changed([](JobSpec& spec) { spec.render.seed = 1; }), digest);
  EXPECT_NE(changed([](JobSpec& spec) { spec.render.samples = 65; }), digest);
  EXPECT_NE(changed([](JobSpec& spec) { spec.render.filter_width = 1; }), digest);
  EXPECT_NE(changed([](JobSpec& spec) { spec.bundle = digest_of("other"); }), digest);
  EXPECT_NE(changed([](JobSpec& spec) { spec.camera = "other"; }), digest);
  EXPECT_NE(changed([](JobSpec& spec) { spec.tile = 32; }), digest);
  EXPECT_NE(changed([](JobSpec& spec) { spec.pass = 128; }), digest);
  EXPECT_NE(changed([](JobSpec& spec) { spec.aov_samples = 4; }), digest);
  EXPECT_NE(changed([](JobSpec& spec) { spec.render.aovs = {"P"}; }), digest);
  EXPECT_NE(changed([](JobSpec& spec) { spec.render.aovs_follow_specular = true; }), digest);
}

}  // namespace
}  // namespace tessera
