#include "worker/agent/agent_state.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/wire/codec.hpp"
#include "tests/unit/agent/fakes.hpp"

namespace tessera::agent {
namespace {

using namespace std::chrono_literals;

class AgentStateTest : public testing::Test {
 protected:
  AgentState state{StateSettings{.outbox_bytes = 1000}};
  JobPlan plan{test_spec()};
  Instant now{1000s};
  std::uint64_t last_lease = 0;

  void connect(std::uint64_t epoch = 1) {
    state.connected({.worker = 1,
                     .epoch = epoch,
                     .heartbeat_ms = 300,
                     .blob_url = "http://a:1",
                     .blob_token = "t"},
                    now);
  }
  LeaseId assign(std::uint32_t tile, std::uint32_t pass = 0, JobId job = 1,
                 const JobPlan* of = nullptr) {
    const JobPlan& by = of != nullptr ? *of : plan;
    const LeaseId lease{.epoch = 1, .number = ++last_lease};
    state.said(wire::Assign{.lease = lease,
                            .job = job,
                            .plan = by.digest,
                            .task = {1, tile, pass},
                            .spec = by.spec},
               now);
    return lease;
  }
  void build() {
    ASSERT_TRUE(state.take_prepare());
    state.prepared(std::make_shared<FakeScene>());
  }
  LeaseId begin() {
    const auto order = state.next_task();
    if (!order) throw std::runtime_error("no task");
    return order->lease;
  }
  void finish(const LeaseId& lease, std::size_t size = 10) {
    RenderedTile stats;
    stats.rays = 5;
    state.task_done(lease, stats, std::make_shared<std::vector<std::byte>>(size));
  }
  /// What was said since the last call, as "preparing 1; result 2; ".
  std::string said() {
    std::string text;
    for (const Outgoing& out : state.take_outgoing()) {
      text += wire::name_of(wire::type_of(out.message));
      if (const auto* m = std::get_if<wire::Result>(&out.message))
        text += " " + std::to_string(m->lease.number);
      if (const auto* m = std::get_if<wire::Failed>(&out.message))
        text += m->lease ? " " + std::to_string(m->lease->number) : " job";
      if (const auto* m = std::get_if<wire::Progress>(&out.message))
        for (const auto& one : m->running) text += " " + std::to_string(one.lease.number);
      text += "; ";
    }
    return text;
  }
};

TEST_F(AgentStateTest, a_task_goes_from_lease_to_acceptance) {
  connect();
  const LeaseId lease = assign(3);
  EXPECT_EQ(said(), "preparing; ");
  EXPECT_FALSE(state.next_task()) << "the scene is not built";
  const auto order = state.take_prepare();
  ASSERT_TRUE(order);
  EXPECT_EQ(order->blob_url, "http://a:1");
  EXPECT_EQ(order->plan->spec, plan.spec);
  EXPECT_FALSE(state.take_prepare()) << "one at a time";
  state.prepared(std::make_shared<FakeScene>());
  EXPECT_EQ(said(), "ready; ");
  const auto task = state.next_task();
  ASSERT_TRUE(task);
  EXPECT_EQ(task->lease, lease);
  EXPECT_EQ(task->task, (TaskId{1, 3, 0}));
  EXPECT_FALSE(state.next_task());
  finish(lease);
  const auto out = state.take_outgoing();
  ASSERT_EQ(out.size(), 1U);
  const auto& result = std::get<wire::Result>(out[0].message);
  EXPECT_EQ(result.lease, lease);
  EXPECT_EQ(result.job, 1U);
  EXPECT_EQ(result.plan, plan.digest);
  EXPECT_EQ(result.task, (TaskId{1, 3, 0}));
  EXPECT_EQ(result.rays, 5);
  EXPECT_EQ(out[0].body->size(), 10U);
  EXPECT_EQ(state.outbox(), 1U);
  state.said(wire::Accepted{.lease = lease}, now);
  EXPECT_EQ(state.outbox(), 0U);
  EXPECT_EQ(state.outbox_bytes(), 0U);
}

TEST_F(AgentStateTest, tasks_are_begun_in_the_order_assigned) {
  connect();
  for (std::uint32_t tile : {5U, 1U, 3U}) assign(tile);
  build();
  for (std::uint32_t tile : {5U, 1U, 3U}) EXPECT_EQ(state.next_task()->task.tile, tile);
}

TEST_F(AgentStateTest, stale_and_rejected_results_are_forgotten_too) {
  connect();
  assign(0);
  assign(1);
  build();
  const LeaseId a = begin(), b = begin();
  finish(a);
  finish(b);
  state.said(wire::Stale{.lease = a}, now);
  state.said(wire::Rejected{.lease = b, .reason = "x"}, now);
  EXPECT_EQ(state.outbox(), 0U);
}

TEST_F(AgentStateTest, no_task_is_begun_while_the_outbox_is_full) {
  connect();
  assign(0);
  assign(1);
  build();
  const LeaseId first = begin();
  finish(first, 1000);
  EXPECT_FALSE(state.next_task());
  state.said(wire::Accepted{.lease = first}, now);
  EXPECT_TRUE(state.next_task());
}

TEST_F(AgentStateTest, after_a_reconnect_the_outbox_is_offered_again_under_the_old_leases) {
  connect();
  assign(0);
  assign(1);
  assign(2);
  build();
  const LeaseId done = begin(), running = begin();
  finish(done);
  said();
  state.disconnected();
  EXPECT_EQ(state.queued(), 0U) << "what was not begun is handed out again by the coordinator";
  finish(running);
  EXPECT_EQ(said(), "") << "nobody to say it to";
  connect(2);
  EXPECT_EQ(said(), "result 1; result 2; ");
  EXPECT_EQ(state.outbox(), 2U);
}

TEST_F(AgentStateTest, a_new_lease_of_a_task_whose_result_is_here_is_not_rendered_again) {
  connect();
  const LeaseId old_lease = assign(0);
  build();
  EXPECT_EQ(begin(), old_lease);
  state.disconnected();
  connect(2);
  assign(0);  // while it renders still
  EXPECT_FALSE(state.next_task());
  finish(old_lease);
  EXPECT_FALSE(state.next_task());
  state.said(wire::Accepted{.lease = old_lease}, now);
  EXPECT_FALSE(state.next_task());
  EXPECT_EQ(state.queued(), 0U);
}

TEST_F(AgentStateTest, but_it_is_if_the_old_result_is_rejected) {
  connect();
  const LeaseId old_lease = assign(0);
  build();
  begin();
  state.disconnected();
  connect(2);
  const LeaseId fresh = assign(0);
  finish(old_lease);
  state.said(wire::Rejected{.lease = old_lease, .reason = "x"}, now);
  EXPECT_EQ(begin(), fresh);
}

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

TEST_F(AgentStateTest, revoked_leases_are_not_begun_and_those_that_render_are_stopped) {
  connect();
  const LeaseId a = assign(0), b = assign(1);
  build();
  EXPECT_EQ(begin(), a);
  said();
  state.said(wire::Revoke{.leases = {a, b, {9, 9}}, .reason = "cancelled"}, now);
  EXPECT_FALSE(state.next_task());
  EXPECT_EQ(state.take_stops(), std::vector<LeaseId>{a});
  finish(a);  // it was done before the stop was seen
  EXPECT_EQ(said(), "");
  EXPECT_EQ(state.outbox(), 0U);
  EXPECT_EQ(state.running(), 0U);
}

TEST_F(AgentStateTest, a_revoked_lease_is_said_to_run_until_its_thread_has_stopped) {
  connect();
  const LeaseId a = assign(0);
  build();
  EXPECT_EQ(begin(), a);
  state.said(wire::Revoke{.leases = {a}, .reason = "no progress for too long"}, now);
  const auto running = [&] {
    state.take_outgoing();
    now += std::chrono::seconds(1);
    state.tick(now);
    std::vector<LeaseId> leases;
    for (const Outgoing& out : state.take_outgoing()) {
      if (const auto* progress = std::get_if<wire::Progress>(&out.message))
        for (const auto& one : progress->running) leases.push_back(one.lease);
    }
    return leases;
  };
  EXPECT_EQ(running(), std::vector<LeaseId>{a});
  state.task_stopped(a);
  EXPECT_TRUE(running().empty());
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

TEST_F(AgentStateTest, a_task_that_fails_is_said_with_its_lease) {
  connect();
  const LeaseId lease = assign(0);
  build();
  begin();
  said();
  state.task_failed(lease, "render", "no memory");
  EXPECT_EQ(said(), "failed 1; ");
  EXPECT_EQ(state.running(), 0U);
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

TEST_F(AgentStateTest, leases_of_an_earlier_connection_are_not_reported_as_running) {
  connect();
  assign(0);
  build();
  begin();
  state.disconnected();
  connect(2);
  said();
  state.tick(now);
  EXPECT_EQ(said(), "progress; ");
}

TEST_F(AgentStateTest, leases_that_make_no_sense_are_refused_by_name) {
  connect();
  state.said(
      wire::Assign{
          .lease = {1, 1}, .job = 8, .plan = plan.digest, .task = {1, 0, 0}, .spec = std::nullopt},
      now);
  EXPECT_EQ(said(), "failed 1; ") << "no description";
  state.said(wire::Assign{.lease = {1, 2},
                          .job = 8,
                          .plan = digest_of("other"),
                          .task = {1, 0, 0},
                          .spec = plan.spec},
             now);
  EXPECT_EQ(said(), "failed 2; ") << "another plan";
  state.said(
      wire::Assign{
          .lease = {1, 3}, .job = 8, .plan = plan.digest, .task = {1, 9999, 0}, .spec = plan.spec},
      now);
  EXPECT_EQ(said(), "failed 3; ") << "no such tile";
  EXPECT_EQ(state.queued(), 0U);
}

TEST_F(AgentStateTest, a_later_lease_of_a_job_needs_no_description) {
  connect();
  assign(0);
  state.said(
      wire::Assign{
          .lease = {1, 77}, .job = 1, .plan = plan.digest, .task = {1, 1, 0}, .spec = std::nullopt},
      now);
  EXPECT_EQ(state.queued(), 2U);
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
