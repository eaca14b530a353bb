#include "client/wedge_jobs.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "client/wedge_sheet.hpp"
#include "tests/unit/client/support.hpp"

namespace tessera::client {
namespace {

class WedgeJobs : public testing::Test {
 protected:
  WedgeJobs() {
    folder_.write("meshes/a.obj", small_mesh);
    job_.scene = folder_.write("ball.json", small_scene);
  }
  [[nodiscard]] WedgePlan plan(const std::vector<const char*>& vary) const {
    std::vector<Vary> axes;
    for (const char* text : vary) axes.push_back(vary_from(text));
    return plan_wedge(job_, std::move(axes));
  }
  TemporaryFolder folder_;
  JobOptions job_;
};

std::string read(const std::filesystem::path& file) {
  std::ostringstream out;
  out << std::ifstream(file, std::ios::binary).rdbuf();
  return out.str();
}

TEST_F(WedgeJobs, jobs_that_vary_no_scene_share_the_scene_on_disk) {
  const PreparedWedge prepared = prepare_wedge(plan({"samples=1,4", "seed=7,8"}));
  EXPECT_EQ(prepared.scene_name, "Ball");
  EXPECT_TRUE(prepared.edited.empty());
  ASSERT_EQ(prepared.scenes.size(), 1U);
  ASSERT_EQ(prepared.jobs.size(), 4U);
  for (const JobSpec& job : prepared.jobs) EXPECT_EQ(job.bundle, prepared.scenes[0].digest);
  EXPECT_EQ(prepared.jobs[3].render.samples, 4);
  EXPECT_EQ(prepared.jobs[3].render.seed, 8U);
  EXPECT_EQ(prepared.jobs[3].render.bounces, 3) << "the scene's";
  EXPECT_EQ(prepared.jobs[3].name, "Ball samples=4 seed=8");
}

TEST_F(WedgeJobs, each_edited_scene_is_a_bundle_that_shares_the_other_files) {
  const PreparedWedge prepared =
      prepare_wedge(plan({"materials.m={\"type\":\"diffuse\",\"reflectance\":0.25},{\"type\":"
                          "\"mirror\"}",
                          "samples=1,2"}));
  ASSERT_EQ(prepared.scenes.size(), 2U);
  EXPECT_EQ(prepared.jobs[0].bundle, prepared.scenes[0].digest);
  EXPECT_EQ(prepared.jobs[1].bundle, prepared.scenes[1].digest);
  EXPECT_EQ(prepared.jobs[2].bundle, prepared.scenes[0].digest);
  EXPECT_NE(prepared.scenes[0].digest, prepared.scenes[1].digest);
  const auto& files = prepared.scenes[1].bundle.files;
  ASSERT_EQ(files.size(), 2U);
  EXPECT_EQ(files.at("meshes/a.obj").digest, digest_of(small_mesh));
  const std::string text = read(prepared.scenes[1].files[0].file);
  EXPECT_EQ(files.at("ball.json").digest, digest_of(text));
  EXPECT_EQ(Json::parse(text).at("materials").at("m").at("type"), "mirror");
  EXPECT_EQ(read(job_.scene), small_scene) << "the file itself stays";
}

TEST_F(WedgeJobs, what_is_wrong_is_said_with_the_values_it_is_wrong_for) {
  const Error scene = error_of([&] {
    (void)prepare_wedge(plan({"samples=1,2", "cameras[1].eye=[0,0,1],3"}));
  });
  EXPECT_EQ(scene.kind(), ErrorKind::bad_input);
  EXPECT_EQ(scene.place().key, "cameras[1].eye");
  EXPECT_EQ(scene.place().line, 0) << "lines of what was edited are not the file's";
  EXPECT_NE(scene.message().find("(with cameras[1].eye=3)"), std::string::npos) << scene.message();
  const Error job = error_of([&] { (void)prepare_wedge(plan({"samples=1,0"})); });
  EXPECT_EQ(job.place().key, "--samples");
  EXPECT_NE(job.message().find("(with samples=0)"), std::string::npos) << job.message();
  const Error path = error_of([&] { (void)prepare_wedge(plan({"materials.n.type=a,b"})); });
  EXPECT_EQ(path.place().key, "--vary materials.n.type");
  const Error camera = error_of([&] { (void)prepare_wedge(plan({"camera=left,rihgt"})); });
  EXPECT_NE(camera.message().find("did you mean \"right\"?"), std::string::npos);
}

TEST_F(WedgeJobs, the_sheet_says_what_varies_as_labels_and_what_does_not_in_its_note) {
  const WedgePlan asked = plan({"samples=1,4,16", "materials.m.type=diffuse,mirror", "seed=1,2"});
  const PreparedWedge prepared = prepare_wedge(asked);
  const SheetContent content = content_of(asked, prepared, 20, {.exposure = 1});
  EXPECT_EQ(content.title, "Ball");
  EXPECT_EQ(content.note,
            "40 × 30 · 1 light sample · path · sobol_owen · tent · 3 bounces · exposure +1 stop");
  EXPECT_EQ(content.column_name, "samples");
  EXPECT_EQ(content.columns, (std::vector<std::string>{"1", "4", "16"}));
  EXPECT_EQ(content.row_name, "materials.m.type");
  EXPECT_EQ(content.rows, (std::vector<std::string>{"diffuse", "mirror"}));
  EXPECT_EQ(content.blocks, (std::vector<std::string>{"seed = 1", "seed = 2"}));
  EXPECT_EQ(content.cell_width, 20);
  EXPECT_EQ(content.cell_height, 15);
}

TEST_F(WedgeJobs, pictures_of_several_sizes_stand_in_boxes_of_the_largest) {
  const WedgePlan asked = plan({"size=10x30,40x20"});
  const SheetContent content = content_of(asked, prepare_wedge(asked), 512, {});
  EXPECT_EQ(content.cell_width, 40);
  EXPECT_EQ(content.cell_height, 30);
  EXPECT_EQ(content.row_name, "");
  EXPECT_EQ(content.note.find("×"), std::string::npos) << content.note;
}

}  // namespace
}  // namespace tessera::client
