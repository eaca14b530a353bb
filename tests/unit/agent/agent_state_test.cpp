#include "tests/unit/agent/agent_state_fixture.hpp"

// Leases and results: from an assignment to the answer, over reconnects and revocations.

namespace tessera::agent {
namespace {

using namespace std::chrono_literals;

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

}  // namespace
}  // namespace tessera::agent
