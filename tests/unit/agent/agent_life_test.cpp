#include "tests/unit/agent/agent_state_fixture.hpp"

// How the agent lives with its coordinator: heartbeats, drain, backoff, refusal.
#include <algorithm>
#include <cmath>

namespace tessera::agent {
namespace {

using namespace std::chrono_literals;

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
