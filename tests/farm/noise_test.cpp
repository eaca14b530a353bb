// Frames of one job end by their noise, each where it ends as a job of its own: with the same bits
// whoever rendered them, and whoever was killed.
#include <gmock/gmock.h>

#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/farm/farm.hpp"

namespace tessera::farm_test {
namespace {

using testing::HasSubstr;

constexpr int easy = 1, hard = 25;
constexpr std::int64_t asked = 4096;

/// A shade that frame 1 does not see and frame 25, a second later, is filled with: nothing but sky,
/// which has no noise, and a surface under sky and lamp, which has much.
std::string scene_in(const TemporaryFolder& folder) {
  folder.write("shade.gltf", R"({"asset": {"version": "2.0"}, "scene": 0,
    "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    "animations": [{"channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
                    "samplers": [{"input": 2, "output": 3}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
                   "min": [-3, -3, 0], "max": [3, 3, 0]},
                  {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
                  {"bufferView": 2, "componentType": 5126, "count": 2, "type": "SCALAR",
                   "min": [0], "max": [1]},
                  {"bufferView": 3, "componentType": 5126, "count": 2, "type": "VEC3"}],
    "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 48},
                    {"buffer": 0, "byteOffset": 48, "byteLength": 12},
                    {"buffer": 0, "byteOffset": 60, "byteLength": 8},
                    {"buffer": 0, "byteOffset": 68, "byteLength": 24}],
    "buffers": [{"byteLength": 92, "uri": "data:application/octet-stream;base64,)"
                             "AABAwAAAQMAAAAAAAABAQAAAQMAAAAAAAABAQAAAQEAAAAAAAABAwAAAQEAAAAAAAAAB"
                             "AAIAAAACAAMAAAAAAAAAgD8AAAAAAAAAAAAASEIAAAAAAAAAAAAAAAA=\"}]}");
  return folder
      .write("scene.json", R"({"tessera": 1, "name": "shade", "include": ["shade.gltf"],
    "film": {"width": 64, "height": 48},
    "camera": {"eye": [0, 0, 5], "target": [0, 0, 0], "fov": 45}, "environment": {"radiance": 1},
    "materials": {"lamp": {"type": "emitter", "radiance": 40}},
    "shapes": [{"type": "quad", "material": "lamp", "corner": [-1, 3, 4], "edge_u": [2, 0, 0],
                "edge_v": [0, 0, 2]}]})")
      .string();
}

std::vector<std::string> job_of(const std::string& frames,
                                const std::vector<std::string>& more = {"--noise", "0.015"},
                                std::int64_t samples = asked) {
  std::vector<std::string> arguments{
      "--samples", std::to_string(samples), "--pass", "16", "--tile", "16", "--frames", frames};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

/// What each frame comes to as a job of its own.
struct Alone {
  std::map<int, image::ExrImage> pictures;
  std::map<int, std::int64_t> samples;
};
const Alone& alone() {
  static const Alone made = [] {
    Alone found;
    Farm farm;
    farm.add_worker();
    for (const int frame : {easy, hard}) {
      const std::string id = farm.submit(scene_in(farm.folder()), job_of(std::to_string(frame)));
      found.pictures[frame] = farm.finish(id);
      found.samples[frame] = farm.job(id).value("samples", std::int64_t{0});
    }
    return found;
  }();
  return made;
}

std::map<int, std::int64_t> samples_of(const nlohmann::json& job) {
  std::map<int, std::int64_t> samples;
  for (const auto& picture : job.at("pictures"))
    samples[picture.at("frame").get<int>()] = picture.at("samples").get<std::int64_t>();
  return samples;
}

void expect_as_alone(const Farm& farm, const std::string& id) {
  ASSERT_EQ(farm.tessera({"wait", id}).code, 0) << farm.logs();
  const nlohmann::json job = farm.job(id);
  EXPECT_EQ(samples_of(job), alone().samples);
  EXPECT_EQ(job.at("samples"), asked) << "the most that a frame may have";
  EXPECT_TRUE(job.at("shortened_from").is_null());
  EXPECT_EQ(job.at("frames_shortened"), 2);
  EXPECT_EQ(job.at("progress"), 1.0);
  std::int64_t all = 0;
  for (const auto& [frame, samples] : alone().samples) all += 64 * 48 * samples;
  EXPECT_EQ(job.at("samples_done"), all);
  EXPECT_EQ(job.at("samples_total"), all);
  EXPECT_EQ(job.at("tasks_done"), job.at("tasks"));
  for (const int frame : {easy, hard}) {
    const image::ExrImage picture = farm.fetch_frame(id, frame);
    const auto different = image::difference(alone().pictures.at(frame), picture);
    EXPECT_FALSE(different.has_value()) << frame << ": " << different.value_or("");
    EXPECT_EQ(picture.metadata.text("tessera.samples"), std::to_string(alone().samples.at(frame)));
  }
}

bool wait_for_frames(const Farm& farm, const std::string& id, int frames) {
  for (int i = 0; i < 6000 && farm.job(id).value("frames_done", 0) < frames; ++i)
    std::this_thread::sleep_for(Seconds(0.01));
  return farm.job(id).value("frames_done", 0) >= frames;
}

TEST(NoiseOfFrames, an_easy_frame_ends_sooner_than_a_hard_one) {
  EXPECT_EQ(alone().samples.at(easy), 16);
  EXPECT_GT(alone().samples.at(hard), 100);
  EXPECT_LT(alone().samples.at(hard), asked);
}

TEST(NoiseOfFrames, each_ends_where_it_does_alone_with_the_same_bits_for_any_number_of_workers) {
  for (const int workers : {1, 3}) {
    SCOPED_TRACE(workers);
    Farm farm;
    for (int i = 0; i < workers; ++i) farm.add_worker();
    expect_as_alone(farm, farm.submit(scene_in(farm.folder()), job_of("1,25")));
  }
}

TEST(NoiseOfFrames, each_ends_where_it_does_alone_though_the_coordinator_is_killed) {
  Farm farm;
  farm.add_worker();
  const std::string id = farm.submit(scene_in(farm.folder()), job_of("1,25"));
  ASSERT_TRUE(wait_for_frames(farm, id, 1)) << farm.logs();
  const nlohmann::json before = farm.job(id);
  ASSERT_EQ(before.value("state", ""), "rendering") << "too late to disturb";
  EXPECT_EQ(samples_of(before)[easy], 16) << "it has ended, and the other goes on";
  EXPECT_EQ(before.at("samples_total"), 64 * 48 * (16 + asked));
  farm.kill_and_restart_server();
  EXPECT_EQ(farm.job(id).at("samples_total"), 64 * 48 * (16 + asked)) << "it is known again";
  ASSERT_TRUE(farm.wait_for_progress(id, 0.03)) << farm.logs();
  farm.kill_and_restart_server();
  expect_as_alone(farm, id);
  farm.kill_and_restart_server();
  expect_as_alone(farm, id);
}

TEST(NoiseOfFrames, a_job_is_extended_to_no_fewer_samples_than_any_frame_has) {
  Farm farm;
  farm.add_worker(2);
  const std::string id = farm.submit(scene_in(farm.folder()), job_of("1,25"));
  ASSERT_EQ(farm.tessera({"wait", id}).code, 0) << farm.logs();
  const std::int64_t most = alone().samples.at(hard);
  const Outcome fewer = farm.tessera({"extend", id, "--samples", std::to_string(most - 1)});
  EXPECT_NE(fewer.code, 0);
  EXPECT_THAT(fewer.errors,
              HasSubstr("expected no fewer samples than the " + std::to_string(most)));

  // The easy frame goes on to what the hard one has, whose picture stands; then both go on.
  for (const std::int64_t samples : {most, most + 20}) {
    ASSERT_EQ(farm.tessera({"extend", id, "--samples", std::to_string(samples)}).code, 0)
        << farm.logs();
    farm.kill_and_restart_server();
    ASSERT_EQ(farm.tessera({"wait", id}).code, 0) << farm.logs();
    const nlohmann::json job = farm.job(id);
    EXPECT_EQ(samples_of(job), (std::map<int, std::int64_t>{{easy, samples}, {hard, samples}}));
    EXPECT_EQ(job.at("noise_threshold"), 0.0) << "who names the samples wants them all";
    EXPECT_EQ(job.at("frames_shortened"), 0);
    const std::string plain = farm.submit(scene_in(farm.folder()), job_of("1,25", {}, samples));
    ASSERT_EQ(farm.tessera({"wait", plain}).code, 0) << farm.logs();
    for (const int frame : {easy, hard}) {
      const auto different =
          image::difference(farm.fetch_frame(plain, frame), farm.fetch_frame(id, frame));
      EXPECT_FALSE(different.has_value()) << frame << ": " << different.value_or("");
    }
  }
  EXPECT_EQ(farm.job(id).at("extended_from"), nlohmann::json({asked, most}));
}

TEST(NoiseOfFrames, that_ended_go_on_to_all_samples_that_were_asked_for) {
  constexpr std::int64_t few = 100;
  Farm farm;
  farm.add_worker(2);
  const std::string id =
      farm.submit(scene_in(farm.folder()), job_of("1,25", {"--noise", "0.015"}, few));
  ASSERT_EQ(farm.tessera({"wait", id}).code, 0) << farm.logs();
  EXPECT_EQ(samples_of(farm.job(id)), (std::map<int, std::int64_t>{{easy, 16}, {hard, few}}));
  ASSERT_EQ(farm.tessera({"extend", id, "--samples", std::to_string(few)}).code, 0) << farm.logs();
  ASSERT_EQ(farm.tessera({"wait", id}).code, 0) << farm.logs();
  EXPECT_EQ(samples_of(farm.job(id)), (std::map<int, std::int64_t>{{easy, few}, {hard, few}}));
  EXPECT_EQ(farm.fetch_frame(id, easy).plane("samples")[0], static_cast<float>(few));
}

}  // namespace
}  // namespace tessera::farm_test
