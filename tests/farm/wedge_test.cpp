// A wedge from the command line to the sheet: on a farm that is there, and on one of its own.
#include <gtest/gtest.h>
#include <signal.h>

#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "tests/farm/farm.hpp"

namespace tessera::farm_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string cornell() { return (sources() / "scenes/cornell.json").string(); }

/// Width and height that a PNG's header says; zeros if it is none.
std::pair<std::uint32_t, std::uint32_t> png_size(const fs::path& file) {
  const std::string bytes = read_text(file);
  if (bytes.size() < 24 || bytes.compare(0, 8, "\x89PNG\r\n\x1a\n") != 0) return {0, 0};
  const auto number = [&](std::size_t at) {
    std::uint32_t out = 0;
    for (std::size_t i = 0; i < 4; ++i) out = out << 8 | static_cast<unsigned char>(bytes[at + i]);
    return out;
  };
  return {number(16), number(20)};
}

std::vector<std::string> wedge(const fs::path& sheet, std::vector<std::string> arguments) {
  std::vector<std::string> all{"wedge", cornell(), "-o", sheet.string(), "--json"};
  all.insert(all.end(), arguments.begin(), arguments.end());
  return all;
}

TEST(Wedge, renders_every_combination_as_a_job_and_says_which_picture_is_which) {
  Farm farm;
  farm.add_worker();
  const fs::path sheet = farm.folder() / "sheet.png";
  const Outcome outcome =
      farm.tessera(wedge(sheet, {"--size", "24x16", "--bounces", "2", "--vary", "samples=1,5",
                                 "--vary", "light_samples=1,3"}));
  ASSERT_EQ(outcome.code, 0) << outcome.errors << farm.logs();
  const json report = json::parse(outcome.output, nullptr, false);
  ASSERT_TRUE(report.is_object()) << outcome.output;
  EXPECT_EQ(report.at("output"), sheet.string());
  EXPECT_EQ(report.at("columns"), 2);
  EXPECT_EQ(report.at("rows"), 2);
  ASSERT_EQ(report.at("cells").size(), 4U);
  std::set<std::string> jobs;
  for (const json& cell : report.at("cells")) {
    jobs.insert(cell.at("job").dump());
    const json expected{{"samples", cell.at("column") == 0 ? 1 : 5},
                        {"light_samples", cell.at("row") == 0 ? 1 : 3}};
    EXPECT_EQ(cell.at("parameters"), expected);
    EXPECT_EQ(cell.at("state"), "done");
    EXPECT_EQ(cell.at("samples"), expected.at("samples"));
    EXPECT_GT(cell.at("cpu_seconds").get<double>(), 0);
    EXPECT_EQ(farm.job(cell.at("job").dump()).at("spec").at("render").at("light_samples"),
              expected.at("light_samples"));
    const std::string file = cell.at("exr");
    const image::ExrImage picture = image::read_exr_file(file);
    EXPECT_EQ(picture.width, 24);
    EXPECT_EQ(picture.metadata.text("tessera.samples"), expected.at("samples").dump());
    EXPECT_EQ(picture.metadata.text("tessera.light_samples"), expected.at("light_samples").dump());
    EXPECT_GT(std::stod(picture.metadata.text("tessera.cpu_seconds")), 0);
    // The farm's own file, bit for bit.
    EXPECT_EQ(image::difference(picture, farm.finish(cell.at("job").dump())), std::nullopt);
  }
  EXPECT_EQ(jobs.size(), 4U);
  EXPECT_TRUE(fs::exists(farm.folder() / "sheet" / "samples=5,light_samples=3.exr"));
  EXPECT_GT(png_size(sheet).first, 2 * 24U);
  EXPECT_GT(png_size(sheet).second, 2 * 16U);
}

TEST(Wedge, on_a_farm_of_its_own_edits_the_scene_and_leaves_its_pictures_alone) {
  const TemporaryFolder temporary;
  const fs::path sheet = temporary / "fov.png";
  std::vector<std::string> all{"/usr/bin/env", "TMPDIR=" + temporary.path().string(),
                               (programs() / "tessera").string()};
  for (const std::string& word :
       wedge(sheet, {"--size", "24x16", "--samples", "2", "--threads", "1", "--exr-dir",
                     (temporary / "exr").string(), "--vary",
                     "materials.white.reflectance=[.2,.2,.2],0.8", "--vary", "seed=1,2"}))
    all.push_back(word);
  const Outcome outcome = run(all, Seconds(120));
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const json cells = json::parse(outcome.output).at("cells");
  ASSERT_EQ(cells.size(), 4U);
  std::vector<image::ExrImage> pictures;
  for (const json& cell : cells)
    pictures.push_back(image::read_exr_file(cell.at("exr").get<std::string>()));
  const auto mean = [](const image::ExrImage& picture) {
    double sum = 0;
    for (const float value : picture.plane("G")) sum += static_cast<double>(value);
    return sum;
  };
  EXPECT_LT(mean(pictures[0]), mean(pictures[1])) << "grey walls are darker than white ones";
  EXPECT_NE(image::difference(pictures[0], pictures[2]), std::nullopt) << "another seed";
  EXPECT_NE(pictures[0].metadata.text("tessera.scene"), pictures[1].metadata.text("tessera.scene"));
  EXPECT_EQ(pictures[0].metadata.text("tessera.scene"), pictures[2].metadata.text("tessera.scene"));
  std::set<std::string> left;
  for (const auto& entry : fs::directory_iterator(temporary.path()))
    left.insert(entry.path().filename().string());
  EXPECT_EQ(left, (std::set<std::string>{"exr", "fov.png"}));
}

TEST(Wedge, a_wrong_path_or_value_is_said_before_anything_is_queued) {
  const Farm farm;
  struct Wrong {
    const char* vary;
    const char* part;
  };
  for (const Wrong& wrong : std::vector<Wrong>{
           {"materials.wite.reflectance=0.1,0.2", "did you mean \"white\"?"},
           {"sampels=1,2", "did you mean \"samples\"?"},
           {"materials.white.reflectance=0.5,1.5", "with materials.white.reflectance=1.5"},
           {"samples=1,0", "with samples=0"},
           {"integrator=path,paht", "did you mean \"path\"?"}}) {
    const Outcome outcome = farm.tessera(wedge(farm.folder() / "s.png", {"--vary", wrong.vary}));
    EXPECT_EQ(outcome.code, 2) << wrong.vary;
    EXPECT_EQ(outcome.output, "");
    EXPECT_NE(outcome.errors.find(wrong.part), std::string::npos) << outcome.errors;
  }
  EXPECT_EQ(farm.get("/v1/jobs").at("jobs").size(), 0U);
  EXPECT_FALSE(fs::exists(farm.folder() / "s"));
}

/// A wedge of small jobs, unless asked four, on a farm whose workers, if any, come later.
Process waiting_wedge(const Farm& farm, const std::string& vary = "samples=1,2,3,4") {
  std::vector<std::string> all{(programs() / "tessera").string(), "--server",
                               "http://" + farm.http()};
  for (const std::string& word :
       wedge(farm.folder() / "sheet.png", {"--size", "16x16", "--vary", vary}))
    all.push_back(word);
  return Process(all, farm.folder() / "wedge");
}

bool has_jobs(const Farm& farm, std::size_t least) {
  return becomes_true([&] { return farm.get("/v1/jobs").at("jobs").size() >= least; });
}

TEST(Wedge, interrupted_cancels_all_its_jobs) {
  const Farm farm;
  Process client = waiting_wedge(farm);
  ASSERT_TRUE(has_jobs(farm, 4)) << client.errors();
  client.signal(SIGINT);
  EXPECT_EQ(client.wait(Seconds(20)), 130) << client.errors();
  const json jobs = farm.get("/v1/jobs").at("jobs");
  for (const json& job : jobs) EXPECT_EQ(job.at("state"), "cancelled");
  EXPECT_NE(client.errors().find("cancelled 4 jobs"), std::string::npos) << client.errors();
}

TEST(Wedge, interrupted_while_it_posts_leaves_no_job_behind) {
  Farm farm;
  std::string seeds = "seed=0";
  for (int seed = 1; seed < 500; ++seed) seeds += "," + std::to_string(seed);
  Process client = waiting_wedge(farm, seeds);
  ASSERT_TRUE(has_jobs(farm, 1)) << client.errors();
  // The server holds a job that the client has asked for and has no answer to.
  farm.server().signal(SIGSTOP);
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  client.signal(SIGINT);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  farm.server().signal(SIGCONT);
  EXPECT_EQ(client.wait(Seconds(60)), 130) << client.errors();
  const json jobs = farm.get("/v1/jobs").at("jobs");
  EXPECT_LT(jobs.size(), 500U) << "it was interrupted too late to say anything";
  for (const json& job : jobs) EXPECT_EQ(job.at("state"), "cancelled") << job.at("id");
}

TEST(Wedge, interrupted_cancels_the_others_if_one_has_ended_meanwhile) {
  const Farm farm;
  Process client = waiting_wedge(farm);
  ASSERT_TRUE(has_jobs(farm, 4)) << client.errors();
  client.signal(SIGSTOP);  // it does not learn what becomes of the first
  EXPECT_EQ(farm.tessera({"cancel", "1"}).code, 0);
  client.signal(SIGINT);
  client.signal(SIGCONT);
  EXPECT_EQ(client.wait(Seconds(20)), 130) << client.errors();
  const json jobs = farm.get("/v1/jobs").at("jobs");
  for (const json& job : jobs) EXPECT_EQ(job.at("state"), "cancelled");
  EXPECT_NE(client.errors().find("cancelled 3 jobs"), std::string::npos) << client.errors();
}

TEST(Wedge, one_that_does_not_come_out_is_named_and_the_others_are_there) {
  Farm farm;
  Process client = waiting_wedge(farm);
  ASSERT_TRUE(has_jobs(farm, 4)) << client.errors();
  EXPECT_EQ(farm.tessera({"cancel", "3"}).code, 0);
  farm.add_worker();
  EXPECT_EQ(client.wait(Seconds(60)), 1) << client.errors();
  EXPECT_NE(client.errors().find("tessera: samples=3: job 3 was cancelled"), std::string::npos)
      << client.errors();
  const json cells = json::parse(client.output(), nullptr, false).at("cells");
  for (const json& cell : cells) {
    const bool lost = cell.at("job") == 3;
    EXPECT_EQ(cell.at("state"), lost ? "cancelled" : "done");
    EXPECT_EQ(cell.at("exr").is_null(), lost);
  }
  EXPECT_GT(png_size(farm.folder() / "sheet.png").first, 0U);
}

}  // namespace
}  // namespace tessera::farm_test
