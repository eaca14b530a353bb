#pragma once
#include <gtest/gtest.h>

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/wire/codec.hpp"
#include "tests/unit/agent/fakes.hpp"
#include "worker/agent/agent_state.hpp"

namespace tessera::agent {

/// A worker's state machine with a connection, a plan, and words for what a coordinator and threads
/// do.
class AgentStateTest : public testing::Test {
 protected:
  AgentState state{StateSettings{.outbox_bytes = 1000}};
  JobPlan plan{test_spec()};
  Instant now{std::chrono::seconds(1000)};
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
  /// What was let go of is freed.
  void free_scenes() { state.take_let_go(); }
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

}  // namespace tessera::agent
