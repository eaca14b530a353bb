#include "client/wedge_plan.hpp"

#include <gtest/gtest.h>

#include <set>

#include "tests/unit/client/support.hpp"

namespace tessera::client {
namespace {

WedgePlan plan_of(const std::vector<const char*>& vary, const JobOptions& job = {}) {
  std::vector<Vary> axes;
  for (const char* text : vary) axes.push_back(vary_from(text));
  return plan_wedge(job, std::move(axes));
}

TEST(WedgePlan, the_first_parameter_gives_columns_and_the_second_rows) {
  const WedgePlan plan = plan_of({"samples=1,4,16", "light_samples=1,2"});
  EXPECT_EQ(plan.columns, 3U);
  EXPECT_EQ(plan.rows, 2U);
  EXPECT_EQ(plan.blocks, 1U);
  ASSERT_EQ(plan.cells.size(), 6U);
  EXPECT_EQ(text_of(plan, plan.cells[0]), "samples=1 light_samples=1");
  EXPECT_EQ(text_of(plan, plan.cells[1]), "samples=4 light_samples=1");
  EXPECT_EQ(text_of(plan, plan.cells[5]), "samples=16 light_samples=2");
  const WedgeCell& cell = plan.cells[4];
  EXPECT_EQ(cell.column, 1U);
  EXPECT_EQ(cell.row, 1U);
  EXPECT_EQ(cell.block, 0U);
  EXPECT_EQ(cell.job.samples, 4);
  EXPECT_EQ(cell.job.light_samples, 2);
  EXPECT_EQ(parameters_of(plan, cell), (Json{{"samples", 4}, {"light_samples", 2}}));
}

TEST(WedgePlan, one_parameter_gives_one_row) {
  const WedgePlan plan = plan_of({"seed=1,2,3"});
  EXPECT_EQ(plan.columns, 3U);
  EXPECT_EQ(plan.rows, 1U);
  EXPECT_EQ(plan.cells[2].job.seed, 3U);
}

TEST(WedgePlan, further_parameters_give_blocks_of_which_the_last_changes_first) {
  const WedgePlan plan = plan_of({"samples=1,4", "bounces=0,1", "seed=1,2", "tile=16,32,64"});
  EXPECT_EQ(plan.blocks, 6U);
  ASSERT_EQ(plan.cells.size(), 24U);
  std::set<std::string> all;
  for (const WedgeCell& cell : plan.cells) all.insert(text_of(plan, cell));
  EXPECT_EQ(all.size(), 24U);
  EXPECT_EQ(text_of(plan, plan.cells[0]), "samples=1 bounces=0 seed=1 tile=16");
  EXPECT_EQ(text_of(plan, plan.cells[4]), "samples=1 bounces=0 seed=1 tile=32");
  EXPECT_EQ(text_of(plan, plan.cells[12]), "samples=1 bounces=0 seed=2 tile=16");
  EXPECT_EQ(plan.cells[14].block, 3U);
  EXPECT_EQ(plan.cells[14].row, 1U);
}

TEST(WedgePlan, every_parameter_of_a_job_reaches_it) {
  const WedgePlan plan =
      plan_of({"samples=8", "light-samples=2", "bounces=3", "integrator=path", "sampler=sobol",
               "seed=9007199254740993", "filter=box", "filter_width=1.5", "width=20", "height=10",
               "camera=left", "tile=16", "pass=4"});
  ASSERT_EQ(plan.cells.size(), 1U);
  const JobOptions& job = plan.cells[0].job;
  EXPECT_EQ(job.samples, 8);
  EXPECT_EQ(job.light_samples, 2);
  EXPECT_EQ(job.bounces, 3);
  EXPECT_EQ(job.integrator, "path");
  EXPECT_EQ(job.sampler, "sobol");
  EXPECT_EQ(job.seed, 9007199254740993U) << "beyond what a double holds";
  EXPECT_EQ(job.filter, "box");
  EXPECT_EQ(job.filter_width, 1.5);
  EXPECT_EQ(job.width, 20);
  EXPECT_EQ(job.height, 10);
  EXPECT_EQ(job.camera, "left");
  EXPECT_EQ(job.tile, 16);
  EXPECT_EQ(job.pass, 4);
  EXPECT_EQ(plan.axes[1].parameter, "light_samples");
  EXPECT_EQ(plan_of({"size=30x20"}).cells[0].job.height, 20);
  EXPECT_EQ(plan_of({"samples=1e3"}).cells[0].job.samples, 1000);
  EXPECT_EQ(plan.scenes.size(), 1U);
  EXPECT_TRUE(plan.scenes[0].empty());
}

TEST(WedgePlan, a_path_that_says_the_same_as_a_flag_is_the_jobs) {
  const WedgePlan plan = plan_of({"render.samples=1,4", "film.width=10,20"});
  EXPECT_EQ(plan.axes[0].parameter, "samples");
  EXPECT_EQ(plan.axes[1].parameter, "width");
  EXPECT_EQ(plan.scenes.size(), 1U);
  EXPECT_EQ(plan.cells[3].job.samples, 4);
  EXPECT_EQ(plan_of({"render.camera=1"}).scenes[0].size(), 1U) << "is no such path";
}

TEST(WedgePlan, a_path_in_the_scene_makes_a_scene_for_each_of_its_values_and_no_more) {
  const WedgePlan plan = plan_of({"samples=1,4", "camera.fov=30,50", "bounces=0,2"});
  ASSERT_EQ(plan.scenes.size(), 2U);
  EXPECT_EQ(plan.scenes[1][0].path, "camera.fov");
  EXPECT_EQ(plan.scenes[1][0].value, 50);
  for (const WedgeCell& cell : plan.cells) EXPECT_EQ(cell.scene, cell.row);
  Json scene = Json::parse(R"({"camera": {"fov": 40}})");
  apply(scene, plan.scenes[1]);
  EXPECT_EQ(scene["camera"]["fov"], 50);
}

TEST(WedgePlan, what_cannot_be_is_refused_at_its_flag) {
  struct Wrong {
    std::vector<const char*> vary;
    const char* key;
    const char* part;
  };
  JobOptions job;
  job.seed = 7;
  job.height = 10;
  for (const Wrong& wrong :
       std::vector<Wrong>{{{}, "--vary", "at least one"},
                          {{"seed=1,2"}, "--vary seed", "a flag fixes"},
                          {{"size=10x10"}, "--vary size", "a flag fixes"},
                          {{"samples=1,2", "samples=4"}, "--vary samples", "varied twice"},
                          {{"samples=1,2", "render.samples=4"}, "--vary samples", "varied twice"},
                          {{"samples=1.5"}, "--vary samples", "a whole number, found 1.5"},
                          {{"samples=many"}, "--vary samples", "a whole number, found \"many\""},
                          {{"bounces=4294967296"}, "--vary bounces", "a whole number"},
                          {{"tile=1e300"}, "--vary tile", "a whole number"},
                          {{"filter_width=wide"}, "--vary filter_width", "a number"},
                          {{"integrator=3"}, "--vary integrator", "a name, found 3"},
                          {{"camera.fov=1,2,3,4,5,6,7,8", "a.b=1,2,3,4,5,6,7,8",
                            "c.d=1,2,3,4,5,6,7,8", "e.f=1,2,3"},
                           "--vary e.f",
                           "more than the 1024 pictures"}}) {
    const Error error = error_of([&] { (void)plan_of(wrong.vary, job); });
    EXPECT_EQ(error.kind(), ErrorKind::bad_input) << wrong.part;
    EXPECT_EQ(error.place().key.rfind(wrong.key, 0), 0U) << error.what();
    EXPECT_NE(error.message().find(wrong.part), std::string::npos) << error.message();
  }
  const Error both = error_of([] { (void)plan_of({"size=1x1,2x2", "width=1,2"}); });
  EXPECT_NE(both.message().find("varied twice"), std::string::npos) << both.message();
}

TEST(WedgePlan, an_edit_of_what_is_not_there_names_the_nearest_of_scene_and_job) {
  Json scene = Json::parse(R"({"camera": {"fov": 40}})");
  const Error path = error_of([&] { apply(scene, {{"camera.fv", 50}}); });
  EXPECT_EQ(path.place().key, "--vary camera.fv");
  EXPECT_NE(path.message().find("did you mean \"fov\"?"), std::string::npos);
  const Error word = error_of([&] { apply(scene, {{"sampels", 50}}); });
  EXPECT_NE(word.message().find("did you mean \"samples\"?"), std::string::npos);
}

TEST(ExrNames, carry_the_parameters_and_are_all_different) {
  EXPECT_EQ(
      exr_names(plan_of({"samples=1,4", "integrator=path"})),
      (std::vector<std::string>{"samples=1,integrator=path.exr", "samples=4,integrator=path.exr"}));
  EXPECT_EQ(exr_names(plan_of({"materials.white.reflectance=[.2,.2,.2],[0.8,1,1]"})),
            (std::vector<std::string>{"materials.white.reflectance=0.2_0.2_0.2.exr",
                                      "materials.white.reflectance=0.8_1_1.exr"}));
  EXPECT_EQ(
      exr_names(plan_of({"shapes[0].file=../a/b.obj,..a/b.obj"})),
      (std::vector<std::string>{"shapes_0_.file=.._a_b.obj.exr", "shapes_0_.file=..a_b.obj.exr"}));
  const std::vector<std::string> alike = exr_names(plan_of({"a.b=x:y,x/y"}));
  EXPECT_EQ(alike, (std::vector<std::string>{"a.b=x_y.exr", "a.b=x_y,2.exr"}));
  const std::string word(300, 'x');
  for (const std::string& name : exr_names(plan_of({("a.b=" + word + "," + word + "z").c_str()})))
    EXPECT_LT(name.size(), 256U);
}

}  // namespace
}  // namespace tessera::client
