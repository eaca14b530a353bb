#include "worker/agent/crew.hpp"

#include <algorithm>
#include <atomic>
#include <new>
#include <optional>
#include <utility>

#include "common/base/error.hpp"
#include "common/image/tile.hpp"

namespace tessera::agent {

namespace {
Instant now() { return std::chrono::steady_clock::now(); }

std::int64_t samples_of(const TaskOrder& order) {
  return order.plan->grid.tile(order.task.tile).pixels() *
         order.plan->passes.pass(order.task.pass).count;
}

TaskEnd failed(const LeaseId& lease, std::string code, std::string reason) {
  return {.lease = lease,
          .what = TaskEnd::What::failed,
          .code = std::move(code),
          .reason = std::move(reason)};
}
}  // namespace

int tasks_at_once(std::int64_t samples, int threads) {
  constexpr std::int64_t samples_per_thread = 16384;  // some ten milliseconds of a simple scene
  const std::int64_t wanted = threads * samples_per_thread / std::max<std::int64_t>(samples, 1) + 1;
  return static_cast<int>(std::clamp<std::int64_t>(wanted, std::min(threads, 2), threads));
}

Crew::Crew(TaskRenderer& renderer, OnEnd on_end, OnProgress on_progress)
    : renderer_(renderer), on_end_(std::move(on_end)), on_progress_(std::move(on_progress)) {
  for (int i = 0; i < renderer.threads(); ++i) lanes_.emplace_back([this] { lane(); });
  encoder_thread_ = std::thread([this] { encoder(); });
}

Crew::~Crew() {
  stop_all();
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  wake_lanes_.notify_all();
  for (std::thread& thread : lanes_) thread.join();
  {
    const std::lock_guard lock(mutex_);
    encoder_ending_ = true;
  }
  wake_encoder_.notify_all();
  encoder_thread_.join();
}

bool Crew::wants_more() const {
  const std::lock_guard lock(mutex_);
  return active_ + static_cast<int>(waiting_.size()) < at_once_ + 1;
}

void Crew::give(TaskOrder order) {
  {
    const std::lock_guard lock(mutex_);
    at_once_ = tasks_at_once(samples_of(order), renderer_.threads());
    stops_.emplace(order.lease, std::stop_source{});
    waiting_.push_back(std::move(order));
  }
  wake_lanes_.notify_one();
}

void Crew::stop(const LeaseId& lease) {
  const std::lock_guard lock(mutex_);
  if (const auto found = stops_.find(lease); found != stops_.end()) found->second.request_stop();
}

void Crew::stop_all() {
  const std::lock_guard lock(mutex_);
  for (auto& [lease, source] : stops_) source.request_stop();
}

CrewStats Crew::stats() const {
  const std::lock_guard lock(mutex_);
  return stats_;
}

bool Crew::may_begin() const {
  return !waiting_.empty() &&
         active_ < tasks_at_once(samples_of(waiting_.front()), renderer_.threads());
}

void Crew::note_begin(Instant at) {
  if (active_++ > 0 || stats_.tasks == 0) return;
  const double gap = seconds(at - idle_since_);
  ++stats_.gaps;
  stats_.gap_seconds += gap;
  stats_.gap_most = std::max(stats_.gap_most, gap);
}

void Crew::note_end(Instant at) {
  ++stats_.tasks;
  if (--active_ == 0) idle_since_ = at;
}

void Crew::lane() {
  std::unique_lock lock(mutex_);
  while (true) {
    wake_lanes_.wait(lock, [this] { return may_begin() || (ending_ && waiting_.empty()); });
    if (waiting_.empty()) return;
    std::optional<TaskOrder> order = std::move(waiting_.front());
    const LeaseId lease = order->lease;
    waiting_.pop_front();
    note_begin(now());
    const std::stop_token stop = stops_.at(lease).get_token();
    if (may_begin()) wake_lanes_.notify_one();
    lock.unlock();
    render(*order, stop);
    // It may be the last that has its scene, which takes a while to be freed.
    order.reset();
    lock.lock();
    note_end(now());
    stops_.erase(lease);
    wake_lanes_.notify_all();
  }
}

void Crew::render(const TaskOrder& order, const std::stop_token& stop) {
  const LeaseId lease = order.lease;
  TaskEnd end{.lease = lease};
  try {
    const RenderRequest request{
        .frame = order.task.frame,
        .window = order.plan->grid.tile(order.task.tile),
        .samples = order.plan->passes.pass(order.task.pass),
        .aovs = order.plan->passes.has_aovs(order.task.pass, order.plan->spec.aov_samples)};
    // The renderer tells often; who asks for the heartbeat is content with ten a second.
    std::atomic<std::int64_t> told{now().time_since_epoch().count()};
    const Fraction progress = [this, lease, &told](double fraction) {
      constexpr std::int64_t interval = 100'000'000;  // ns
      const std::int64_t at = now().time_since_epoch().count();
      std::int64_t before = told.load();
      if (at - before >= interval && told.compare_exchange_strong(before, at))
        on_progress_(lease, fraction);
    };
    std::optional<RenderedTile> tile;
    if (!stop.stop_requested())
      tile = renderer_.render(*order.scene, order.plan->spec, request, progress, stop);
    if (tile) {
      {
        const std::lock_guard lock(mutex_);
        encoding_.push_back({.lease = lease, .tile = std::move(*tile)});
      }
      wake_encoder_.notify_one();
      return;
    }
  } catch (const std::bad_alloc&) {
    end = failed(lease, "memory", "there is not enough memory to render this task");
  } catch (const std::exception& error) {
    end = failed(lease, "render", error.what());
  }
  on_end_(std::move(end));
}

void Crew::encoder() {
  std::unique_lock lock(mutex_);
  while (true) {
    wake_encoder_.wait(lock, [this] { return !encoding_.empty() || encoder_ending_; });
    if (encoding_.empty()) return;
    Encoding one = std::move(encoding_.front());
    encoding_.pop_front();
    lock.unlock();
    TaskEnd end{.lease = one.lease, .what = TaskEnd::What::done};
    try {
      end.bytes =
          std::make_shared<const std::vector<std::byte>>(image::encode_tile(one.tile.image));
      one.tile.image = {};
      end.stats = std::move(one.tile);
    } catch (const std::exception& error) {
      end = failed(one.lease, "render", error.what());
    }
    on_end_(std::move(end));
    lock.lock();
  }
}

}  // namespace tessera::agent
