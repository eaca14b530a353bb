// What is kept for people: attempts that gave no result, and requests that may be repeated.
#include <gmock/gmock.h>

#include "tests/unit/session/farm.hpp"

namespace tessera::server {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class Failures : public testing::Test {
 protected:
  Farm farm;
};

TEST_F(Failures, what_a_worker_says_is_kept_with_its_log_over_a_restart) {
  JobId id = 0;
  const JobSpec spec = farm.spec();
  ScriptedWorker worker("render-1", '1');
  bool failed = false;
  worker.on_assign = [&](const wire::Assign& order) {
    if (std::exchange(failed, true)) return worker.deliver(order);
    wire::Failed message;
    message.job = order.job;
    message.lease = order.lease;
    message.code = "memory";
    message.reason = "no memory for 3 textures";
    message.log = "one line\nanother\n";
    worker.stream().send(message);
  };
  const auto scenario = [&]() -> awaitable<void> {
    id = co_await farm.coordinator->submit(spec);
    co_await worker.connect(farm);
    co_await worker.work([&] { return farm.coordinator->job(id)->view.state == "done"; });
    const std::vector<FailureRecord> failures = co_await farm.coordinator->failures(id);
    EXPECT_EQ(failures.size(), 1U);
    EXPECT_EQ(farm.coordinator->job(id)->failures, 1U);
    worker.vanish();
  };
  farm.run(scenario());
  farm.kill();
  farm.start();
  const auto after = [&]() -> awaitable<void> {
    EXPECT_EQ(farm.coordinator->job(id)->failures, 1U);
    const std::vector<FailureRecord> failures = co_await farm.coordinator->failures(id);
    if (failures.size() != 1) co_return ADD_FAILURE() << failures.size() << " failures";
    const FailureRecord& failure = failures.front();
    EXPECT_EQ(failure.outcome, "failed");
    EXPECT_EQ(failure.worker_name, "render-1");
    EXPECT_EQ(failure.reason, "no memory for 3 textures");
    EXPECT_EQ(failure.log, "one line\nanother\n");
    EXPECT_TRUE(failure.task.has_value());
    EXPECT_GE(failure.ended, failure.started);
    EXPECT_GT(failure.started, 0);
  };
  farm.run(after());
}

TEST_F(Failures, a_worker_that_vanishes_has_lost_what_it_ran) {
  ScriptedWorker gone("gone", '1'), good("good", '2');
  std::size_t orders = 0;
  gone.on_assign = [&](const wire::Assign&) { ++orders; };
  const auto scenario = [&]() -> awaitable<void> {
    const JobSpec spec = farm.spec();
    const JobId id = co_await farm.coordinator->submit(spec);
    co_await gone.connect(farm);
    co_await gone.work([&] { return orders > 0; });
    gone.vanish();
    co_await good.connect(farm);
    co_await good.work([&] { return farm.coordinator->job(id)->view.state == "done"; });
    const std::vector<FailureRecord> failures = co_await farm.coordinator->failures(id);
    if (failures.size() != 1) co_return ADD_FAILURE() << failures.size() << " failures";
    EXPECT_EQ(failures.front().outcome, "lost");
    EXPECT_EQ(failures.front().worker_name, "gone");
    EXPECT_EQ(failures.front().log, "");
  };
  farm.run(scenario());
}

TEST_F(Failures, a_quarantined_worker_is_told_why_and_when_it_is_released) {
  ScriptedWorker worker("barred", '1');
  const auto scenario = [&]() -> awaitable<void> {
    co_await worker.connect(farm);
    co_await farm.coordinator->quarantine("barred", "its fan is broken");
    co_await worker.work([&] { return !worker.told.empty(); });
    co_await farm.coordinator->release("barred");
    co_await worker.work([&] { return worker.told.size() > 1; });
  };
  farm.run(scenario());
  EXPECT_THAT(worker.told,
              ElementsAre(HasSubstr("quarantined: its fan is broken"), HasSubstr("released")));
}

TEST_F(Failures, a_submission_under_a_known_key_gives_the_first_job_also_after_a_restart) {
  const JobSpec spec = farm.spec();
  JobSpec other = spec;
  other.render.seed = 7;
  const auto before = [&]() -> awaitable<void> {
    const Submitted first = co_await farm.coordinator->submit_once(spec, "key");
    EXPECT_EQ(first.job, 1U);
    const Submitted again = co_await farm.coordinator->submit_once(spec, "key");
    EXPECT_EQ(again.job, 1U);
    EXPECT_FALSE(again.of_another_request);
    const Submitted second = co_await farm.coordinator->submit_once(spec, "another key");
    EXPECT_EQ(second.job, 2U);
  };
  farm.run(before());
  farm.kill();
  farm.start();
  const auto after = [&]() -> awaitable<void> {
    const Submitted again = co_await farm.coordinator->submit_once(spec, "key");
    EXPECT_EQ(again.job, 1U);
    EXPECT_FALSE(again.of_another_request);
    const Submitted odd = co_await farm.coordinator->submit_once(other, "key");
    EXPECT_EQ(odd.job, 1U);
    EXPECT_TRUE(odd.of_another_request);
    EXPECT_EQ(farm.coordinator->jobs().size(), 2U);
  };
  farm.run(after());
}

TEST_F(Failures, a_key_whose_job_was_refused_can_be_used_again) {
  const auto scenario = [&]() -> awaitable<void> {
    const JobSpec good = farm.spec();
    JobSpec lacking = good;
    lacking.bundle = digest_of("not here");
    bool refused = false;
    try {
      co_await farm.coordinator->submit_once(lacking, "key");
    } catch (const Error& error) {
      refused = error.kind() == ErrorKind::conflict;
    }
    EXPECT_TRUE(refused);
    const Submitted taken = co_await farm.coordinator->submit_once(good, "key");
    EXPECT_EQ(taken.job, 1U);
  };
  farm.run(scenario());
}

TEST_F(Failures, two_submissions_at_once_under_one_key_are_one_job) {
  const JobSpec spec = farm.spec();
  std::vector<JobId> jobs;
  const auto submit = [&]() -> awaitable<void> {
    const Submitted submitted = co_await farm.coordinator->submit_once(spec, "key");
    jobs.push_back(submitted.job);
  };
  const auto scenario = [&]() -> awaitable<void> {
    const auto one = farm.go(submit());
    const auto two = farm.go(submit());
    while (!*one || !*two) co_await sleep_for(std::chrono::milliseconds(1));
  };
  farm.run(scenario());
  EXPECT_THAT(jobs, ElementsAre(1U, 1U));
  EXPECT_EQ(farm.coordinator->jobs().size(), 1U);
}

}  // namespace
}  // namespace tessera::server
