#pragma once
#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/base/error.hpp"
#include "server/coordinator/coordinator.hpp"

/// A coordinator of which tests see every call and set every answer. Pictures are short texts that
/// say what was asked.
namespace tessera::server {

class FakeCoordinator : public Coordinator {
 public:
  std::map<JobId, JobStatus> known;
  std::vector<WorkerView> connected;
  CoordinatorCounters counted;
  std::vector<std::string> calls;
  std::map<std::string, JobId> keys;
  std::vector<FailureRecord> failed_attempts;
  std::uint64_t present_version = 7;
  std::string disk_trouble;
  std::size_t picture_bytes = 0;  ///< 0: the short text alone

  static JobSpec spec(const std::string& name = "cornell") {
    JobSpec out;
    out.name = name;
    out.render.width = 32;
    out.render.height = 16;
    out.render.samples = 4;
    out.tile = 16;
    return out;
  }

  JobStatus& add(JobId id, const std::string& state = "rendering", const JobSpec& of = spec()) {
    JobStatus status;
    status.plan = std::make_shared<const JobPlan>(of);
    status.view.id = id;
    status.view.state = state;
    status.view.tasks = status.plan->tasks();
    status.created = 1'700'000'000'000;
    return known[id] = status;
  }

  static Event event(std::uint64_t number, const std::string& type, JobId job,
                     const std::string& data) {
    Event out;
    out.number = number;
    out.type = type;
    out.job = job;
    out.data = data;
    return out;
  }

  /// Events that every new subscription finds waiting; after them nothing comes.
  std::deque<Event> events;
  bool stopped = false;

  boost::asio::awaitable<JobId> submit(JobSpec job) override {
    if (!full.empty()) throw Error(ErrorKind::no_room, full);
    calls.push_back("submit " + job.name);
    if (job.name == "lacking")
      throw Error(ErrorKind::conflict, "the bundle is not in the blob store", {.key = "bundle"});
    if (job.name == "broken") throw std::runtime_error("a secret of the server's");
    const JobId id = known.size() + 1;
    add(id, "queued", job);
    co_return id;
  }
  boost::asio::awaitable<Submitted> submit_once(JobSpec job, std::string key) override {
    const std::string name = job.name;
    Submitted submitted;
    const auto earlier = keys.find(key);
    if (earlier != keys.end()) {
      submitted.job = earlier->second;
      submitted.of_another_request = known.at(submitted.job).plan->spec.name != name;
    } else {
      submitted.job = co_await submit(std::move(job));
      keys[key] = submitted.job;
    }
    co_return submitted;
  }
  boost::asio::awaitable<std::vector<FailureRecord>> failures(JobId) override {
    co_return failed_attempts;
  }
  [[nodiscard]] std::string trouble() const override { return disk_trouble; }
  [[nodiscard]] CoordinatorCounters counters() const override { return counted; }
  [[nodiscard]] std::vector<JobStatus> jobs() const override {
    std::vector<JobStatus> out;
    for (const auto& [id, status] : known) out.push_back(status);
    return out;
  }
  [[nodiscard]] std::optional<JobStatus> job(JobId id) const override {
    const auto found = known.find(id);
    if (found == known.end()) return std::nullopt;
    return found->second;
  }
  boost::asio::awaitable<void> cancel(JobId id) override { co_return change(id, "cancelled"); }
  boost::asio::awaitable<void> purge(JobId id) override {
    if (known.at(id).view.state != "done")
      throw Error(ErrorKind::conflict, "the job has not ended: cancel it first");
    calls.push_back("purge " + std::to_string(id));
    known.erase(id);
    co_return;
  }
  boost::asio::awaitable<void> pause(JobId id) override { co_return change(id, "paused"); }
  boost::asio::awaitable<void> resume(JobId id) override { co_return change(id, "rendering"); }
  boost::asio::awaitable<void> change(JobId id, JobChange change) override {
    JobStatus& status = known.at(id);
    JobSpec spec = status.plan->spec;
    if (change.priority) {
      calls.push_back("priority " + std::to_string(*change.priority));
      status.view.priority = *change.priority;  // the plan keeps the one that was submitted
    }
    if (change.max_workers) spec.max_workers = *change.max_workers;
    if (change.focus && *change.focus) check_focus(**change.focus, spec.render);
    if (change.focus) spec.focus = *change.focus;
    status.plan = std::make_shared<const JobPlan>(spec);
    co_return;
  }
  boost::asio::awaitable<void> extend(JobId id, std::int64_t samples) override {
    calls.push_back("extend " + std::to_string(samples));
    known.at(id).view.state = "queued";
    co_return;
  }
  std::string full;                   ///< why nothing new is taken
  std::optional<std::uint64_t> room;  ///< uploads of so many bytes are, though
  [[nodiscard]] std::string lacks_room(std::uint64_t more) const override {
    return room && more <= *room ? std::string() : full;
  }
  StorageUse stored;
  [[nodiscard]] StorageUse storage() const override { return stored; }

  boost::asio::awaitable<Picture> exr(JobId id, std::int32_t frame) override {
    co_return picture("exr", id, frame, "");
  }
  boost::asio::awaitable<Picture> png(JobId id, std::int32_t frame, double stops) override {
    co_return picture("png", id, frame, " " + std::to_string(stops));
  }
  boost::asio::awaitable<Picture> tiles(JobId id, std::int32_t frame,
                                        std::uint64_t since) override {
    co_return picture("tiles", id, frame, " since " + std::to_string(since));
  }
  [[nodiscard]] std::optional<std::uint64_t> version(JobId id, std::int32_t) const override {
    if (known.count(id) == 0) return std::nullopt;
    return present_version;
  }

  [[nodiscard]] std::optional<std::int64_t> samples(JobId id, std::int32_t) const override {
    if (known.count(id) == 0) return std::nullopt;
    return frame_samples.value_or(known.at(id).plan->passes.samples());
  }
  std::optional<std::int64_t> frame_samples;  ///< of each frame; else the plan's

  std::unique_ptr<Subscription> subscribe(std::optional<JobId> job) override {
    calls.push_back(job ? "subscribe " + std::to_string(*job) : "subscribe all");
    return std::make_unique<FakeSubscription>(*this);
  }

  [[nodiscard]] std::vector<WorkerView> workers() const override { return connected; }
  void drain_worker(WorkerId worker) override {
    calls.push_back("drain " + std::to_string(worker));
    state_of(worker) = "draining";
  }
  boost::asio::awaitable<void> quarantine(std::string name, std::string reason) override {
    if (!full.empty()) throw Error(ErrorKind::no_room, full);
    calls.push_back("quarantine " + name + ": " + reason);
    std::erase_if(barred, [&](const Quarantine& one) { return one.name == name; });
    Quarantine made;
    made.name = name;
    made.reason = reason;
    made.by = "user";
    made.since = 1'700'000'000'000;
    barred.push_back(made);
    for (WorkerView& worker : connected)
      if (worker.info.name == name) worker.state = "quarantined";
    co_return;
  }
  boost::asio::awaitable<void> release(std::string name) override {
    calls.push_back("release " + name);
    std::erase_if(barred, [&](const Quarantine& one) { return one.name == name; });
    for (WorkerView& worker : connected)
      if (worker.info.name == name) worker.state = "idle";
    co_return;
  }
  std::vector<Quarantine> barred;
  [[nodiscard]] std::vector<Quarantine> quarantines() const override { return barred; }
  [[nodiscard]] std::uint64_t epoch() const override { return 3; }

  WorkerId worker_joined(const WorkerInfo&, std::shared_ptr<WorkerLink>) override { return 0; }
  void worker_heard(WorkerId) override {}
  void excuse_worker(WorkerId) override {}
  void worker_said(WorkerId, wire::Message) override {}
  void worker_result(WorkerId, wire::Result, std::vector<std::byte>) override {}
  void worker_left(WorkerId, bool) override {}
  boost::asio::awaitable<void> stop() override { co_return; }

 private:
  std::string& state_of(WorkerId id) {
    return std::find_if(connected.begin(), connected.end(),
                        [id](const WorkerView& worker) { return worker.id == id; })
        ->state;
  }
  class FakeSubscription : public Subscription {
   public:
    explicit FakeSubscription(FakeCoordinator& from) : from_(from), waiting_(from.events) {}
    boost::asio::awaitable<std::optional<Event>> next(Duration wait) override {
      if (!waiting_.empty()) {
        Event first = waiting_.front();
        waiting_.pop_front();
        co_return first;
      }
      if (from_.stopped) co_return std::nullopt;
      boost::asio::steady_timer timer(co_await boost::asio::this_coro::executor, wait);
      boost::system::error_code error;
      co_await timer.async_wait(boost::asio::redirect_error(boost::asio::use_awaitable, error));
      co_return std::nullopt;
    }

   private:
    FakeCoordinator& from_;
    std::deque<Event> waiting_;
  };

  void change(JobId id, const std::string& state) {
    calls.push_back(state);
    if (known.at(id).view.state == "done") throw Error(ErrorKind::conflict, "the job is done");
    known.at(id).view.state = state;
  }

  Picture picture(const std::string& what, JobId id, std::int32_t frame, const std::string& more) {
    const std::string text =
        what + " of " + std::to_string(id) + " frame " + std::to_string(frame) + more;
    calls.push_back(text);
    auto bytes = std::make_shared<std::vector<std::byte>>();
    for (const char c : text) bytes->push_back(static_cast<std::byte>(c));
    if (picture_bytes > 0) bytes->resize(picture_bytes);
    Picture out;
    out.version = present_version;
    out.bytes = bytes;
    return out;
  }
};

}  // namespace tessera::server
