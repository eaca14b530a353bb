#include "tests/unit/agent/agent_state_fixture.hpp"

// Which scenes are built, kept and let go of.
namespace tessera::agent {
namespace {

TEST_F(AgentStateTest, the_scene_is_kept_over_a_reconnect_and_ready_is_said_at_once) {
  connect();
  assign(0);
  build();
  state.disconnected();
  connect(2);
  said();
  assign(1);
  EXPECT_EQ(said(), "ready; ");
  EXPECT_TRUE(state.next_task());
}

TEST_F(AgentStateTest, a_scene_that_nobody_wants_any_more_is_not_built_on) {
  connect();
  const LeaseId lease = assign(0);
  ASSERT_TRUE(state.take_prepare());
  EXPECT_FALSE(state.prepare_unwanted());
  state.said(wire::Revoke{.leases = {lease}, .reason = "cancelled"}, now);
  EXPECT_TRUE(state.prepare_unwanted());
  state.prepare_stopped();
  EXPECT_FALSE(state.prepare_unwanted());
  assign(1);
  EXPECT_TRUE(state.take_prepare()) << "wanted again";
}

TEST_F(AgentStateTest, a_lost_connection_does_not_stop_a_scene_that_is_being_built) {
  connect();
  assign(0);
  ASSERT_TRUE(state.take_prepare());
  state.disconnected();
  EXPECT_FALSE(state.prepare_unwanted());
  state.prepared(std::make_shared<FakeScene>());
  connect(2);
  said();
  assign(0);
  EXPECT_EQ(said(), "ready; ");
}

TEST_F(AgentStateTest, a_scene_that_cannot_be_built_gives_all_its_leases_back) {
  connect();
  assign(0);
  assign(1);
  ASSERT_TRUE(state.take_prepare());
  said();
  state.prepare_failed("scene", "cornell.json:3:1: no such material");
  EXPECT_EQ(said(), "failed job; ");
  EXPECT_EQ(state.queued(), 0U);
  assign(2);
  EXPECT_TRUE(state.take_prepare()) << "asked again, it is tried again";
}

TEST_F(AgentStateTest, a_scene_whose_job_is_gone_meanwhile_is_freed_by_another_thread) {
  connect();
  assign(0);
  ASSERT_TRUE(state.take_prepare());
  state.prepare_stopped();
  auto scene = std::make_shared<FakeScene>();
  const std::weak_ptr<const PreparedScene> watch = scene;
  state.prepared(std::move(scene));
  EXPECT_FALSE(watch.expired());
  free_scenes();
  EXPECT_TRUE(watch.expired());
}

TEST_F(AgentStateTest, only_the_scenes_used_last_are_kept) {
  connect();
  std::vector<std::unique_ptr<JobPlan>> plans;
  std::vector<std::weak_ptr<const PreparedScene>> scenes;
  for (JobId job = 1; job <= 4; ++job) {
    JobSpec spec = test_spec();
    spec.render.seed = job;
    plans.push_back(std::make_unique<JobPlan>(spec));
    const LeaseId lease = assign(0, 0, job, plans.back().get());
    ASSERT_TRUE(state.take_prepare());
    auto scene = std::make_shared<FakeScene>();
    scenes.push_back(scene);
    state.prepared(std::move(scene));
    begin();
    finish(lease);
  }
  EXPECT_FALSE(scenes[0].expired()) << "it is freed by another thread";
  free_scenes();
  EXPECT_TRUE(scenes[0].expired());
  EXPECT_TRUE(scenes[1].expired());
  EXPECT_FALSE(scenes[2].expired());
  EXPECT_FALSE(scenes[3].expired());
  assign(1, 0, 1, plans[0].get());
  EXPECT_TRUE(state.take_prepare()) << "built again when wanted again";
}

/// Two jobs of one bundle, of which the second asks for more.
class LesserScene : public AgentStateTest {
 protected:
  LesserScene() {
    JobSpec spec = test_spec();
    spec.render.aovs = {"UV"};
    more = std::make_unique<JobPlan>(spec);
    connect();
  }
  /// Builds for the first job a scene that does not serve the second.
  std::weak_ptr<const PreparedScene> build_lesser() {
    EXPECT_TRUE(state.take_prepare());
    auto scene = std::make_shared<FakeScene>(false);
    const std::weak_ptr<const PreparedScene> watch = scene;
    state.prepared(std::move(scene));
    return watch;
  }

  std::unique_ptr<JobPlan> more;
};

TEST_F(LesserScene, goes_before_one_that_keeps_more_is_built_where_no_lease_needs_it) {
  const LeaseId lease = assign(0);
  const std::weak_ptr<const PreparedScene> lesser = build_lesser();
  begin();
  finish(lease);
  EXPECT_FALSE(lesser.expired()) << "kept for tasks to come";
  assign(0, 0, 2, more.get());
  ASSERT_TRUE(state.take_prepare());
  EXPECT_FALSE(lesser.expired()) << "it is freed by another thread";
  free_scenes();
  EXPECT_TRUE(lesser.expired());
  state.prepared(std::make_shared<FakeScene>(true));
  EXPECT_EQ(state.next_task()->job.first, 2U);
  assign(1);
  EXPECT_TRUE(state.take_prepare()) << "its job takes the one that is there";
}

TEST_F(LesserScene, in_use_goes_with_the_last_task_that_renders_from_it) {
  const LeaseId first = assign(0);
  assign(1);
  const std::weak_ptr<const PreparedScene> lesser = build_lesser();
  std::optional<TaskOrder> rendering = state.next_task();
  ASSERT_TRUE(rendering);
  assign(0, 0, 2, more.get());
  ASSERT_TRUE(state.take_prepare());
  EXPECT_FALSE(lesser.expired());
  said();
  const auto larger = std::make_shared<FakeScene>(true);
  state.prepared(larger);
  EXPECT_EQ(said(), "ready; ") << "the first job was ready before";
  EXPECT_EQ(rendering->scene, lesser.lock());
  const std::optional<TaskOrder> later = state.next_task();
  ASSERT_TRUE(later);
  EXPECT_EQ(later->job.first, 1U);
  EXPECT_EQ(later->scene, larger);
  EXPECT_EQ(state.next_task()->scene, larger);
  free_scenes();
  EXPECT_FALSE(lesser.expired());
  rendering.reset();
  EXPECT_TRUE(lesser.expired());
  finish(first);
}

TEST_F(LesserScene, stays_where_another_scene_is_built) {
  const LeaseId lease = assign(0);
  const std::weak_ptr<const PreparedScene> lesser = build_lesser();
  begin();
  finish(lease);
  JobSpec spec = more->spec;
  spec.bundle = digest_of("another");
  const JobPlan other(spec);
  assign(0, 0, 2, &other);
  ASSERT_TRUE(state.take_prepare());
  state.prepared(std::make_shared<FakeScene>(true));
  free_scenes();
  ASSERT_FALSE(lesser.expired());
  assign(1);
  EXPECT_EQ(state.next_task()->job.first, 2U);
  EXPECT_EQ(state.next_task()->scene, lesser.lock());
}

TEST_F(LesserScene, that_gave_way_leaves_room_for_another_bundles) {
  JobSpec spec = more->spec;
  spec.bundle = digest_of("another");
  const JobPlan other(spec);
  const LeaseId lease = assign(0, 0, 3, &other);
  ASSERT_TRUE(state.take_prepare());
  auto scene = std::make_shared<FakeScene>(true);
  const std::weak_ptr<const PreparedScene> of_other = scene;
  state.prepared(std::move(scene));
  begin();
  finish(lease);
  assign(0);
  build_lesser();
  assign(0, 0, 2, more.get());
  ASSERT_TRUE(state.take_prepare());
  state.prepared(std::make_shared<FakeScene>(true));
  free_scenes();
  EXPECT_FALSE(of_other.expired()) << "two jobs have the other scene, and it is one";
}

}  // namespace
}  // namespace tessera::agent
