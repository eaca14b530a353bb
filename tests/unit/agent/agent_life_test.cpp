#include "tests/unit/agent/agent_state_fixture.hpp"

// What is built and kept, and how the agent lives with its coordinator: heartbeats, drain, backoff,
// refusal.
#include <algorithm>
#include <cmath>

namespace tessera::agent {
namespace {

using namespace std::chrono_literals;

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
  EXPECT_TRUE(scenes[0].expired());
  EXPECT_TRUE(scenes[1].expired());
  EXPECT_FALSE(scenes[2].expired());
  EXPECT_FALSE(scenes[3].expired());
  assign(1, 0, 1, plans[0].get());
  EXPECT_TRUE(state.take_prepare()) << "built again when wanted again";
}

TEST_F(AgentStateTest, heartbeats_come_at_least_as_often_as_asked_and_name_what_renders) {
  connect();
  state.tick(now);
  EXPECT_EQ(said(), "progress; ");
  state.tick(now + 100ms);
  EXPECT_EQ(said(), "");
  const LeaseId lease = assign(0);
  assign(1);
  said();
  now = state.next_beat();
  EXPECT_LE(now, Instant{1000s} + 300ms);
  state.prepare_progress(0.25);
  state.tick(now);
  EXPECT_EQ(said(), "progress; preparing; ");
  build();
  begin();
  state.task_progress(lease, 0.5);
  said();
  state.tick(state.next_beat());
  EXPECT_EQ(said(), "progress 1; ");
}

TEST_F(AgentStateTest, a_drain_begins_nothing_more_and_ends_when_all_is_delivered) {
  connect();
  assign(0);
  assign(1);
  build();
  const LeaseId running = begin();
  said();
  state.drain("restart");
  EXPECT_EQ(said(), "drain; ");
  EXPECT_FALSE(state.next_task());
  EXPECT_FALSE(state.finished());
  finish(running);
  EXPECT_FALSE(state.finished());
  state.said(wire::Accepted{.lease = running}, now);
  EXPECT_TRUE(state.finished());
  assign(2);
  EXPECT_EQ(state.queued(), 0U);
}

TEST_F(AgentStateTest, the_coordinator_can_ask_for_a_drain) {
  connect();
  state.said(wire::Drain{.reason = "quarantine"}, now);
  EXPECT_TRUE(state.draining());
  EXPECT_TRUE(state.finished());
}

TEST(AgentBackoff, waits_double_up_to_the_most_with_jitter_and_begin_anew_after_a_welcome) {
  AgentState state({.backoff_first = 100ms, .backoff_most = 2s, .jitter = 3});
  Duration wait{};
  for (int attempt = 0; attempt < 50; ++attempt) {
    wait = state.disconnected();
    const double most = std::min(2.0, 0.1 * std::pow(2, attempt));
    EXPECT_LE(seconds(wait), most + 1e-9);
    EXPECT_GE(seconds(wait), 0.5 * most - 1e-9);
  }
  state.connected({}, Instant{});
  EXPECT_LE(state.disconnected(), 100ms);
  AgentState other({.backoff_first = 100ms, .backoff_most = 2s, .jitter = 4});
  AgentState again({.backoff_first = 100ms, .backoff_most = 2s, .jitter = 4});
  EXPECT_EQ(other.disconnected(), again.disconnected());
}

TEST(AgentRefusal, what_will_not_change_ends_the_program) {
  const auto code = [](const char* name) {
    return AgentState::refused({.code = name, .reason = ""});
  };
  EXPECT_EQ(code("token"), 4);
  EXPECT_EQ(code("quarantined"), 4);
  EXPECT_EQ(code("build"), 4);
  EXPECT_EQ(code("version"), 1);
  EXPECT_EQ(code("protocol"), 1);
  EXPECT_EQ(code("full"), std::nullopt);
}

}  // namespace
}  // namespace tessera::agent
