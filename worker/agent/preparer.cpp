#include "worker/agent/preparer.hpp"

#include <fmt/format.h>

#include <chrono>
#include <new>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/log.hpp"

namespace tessera::agent {

namespace {
/// The files stay pinned in the cache as long as the scene may read them.
struct PinnedScene {
  PinnedScene(std::shared_ptr<const PreparedScene> built, FetchedBundle read)
      : scene(std::move(built)), files(std::move(read)) {}
  std::shared_ptr<const PreparedScene> scene;
  FetchedBundle files;
};
}  // namespace

Preparer::Preparer(TaskRenderer& renderer, Fetcher& fetcher, OnEnd on_end, Fraction on_progress,
                   OnCache on_cache)
    : renderer_(renderer),
      fetcher_(fetcher),
      on_end_(std::move(on_end)),
      on_progress_(std::move(on_progress)),
      on_cache_(std::move(on_cache)),
      thread_([this] { work(); }) {}

Preparer::~Preparer() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
    stop_.request_stop();
  }
  wake_.notify_all();
  thread_.join();
}

void Preparer::begin(PrepareOrder order) {
  {
    const std::lock_guard lock(mutex_);
    stop_ = std::stop_source{};
    next_ = std::move(order);
  }
  wake_.notify_all();
}

void Preparer::stop() {
  const std::lock_guard lock(mutex_);
  stop_.request_stop();
}

void Preparer::let_go(std::vector<std::shared_ptr<const PreparedScene>> scenes) {
  let_go_.put(std::move(scenes));
}

void Preparer::work() {
  try {
    fetcher_.tidy();
  } catch (const std::exception& error) {
    log::warn("the cache cannot be tidied: {}", error.what());
  }
  on_cache_(fetcher_.cache());
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return next_.has_value() || ending_; });
    if (ending_) return;
    const PrepareOrder order = *std::exchange(next_, std::nullopt);
    const std::stop_token stop = stop_.get_token();
    lock.unlock();
    PrepareEnd end = prepare(order, stop);
    on_cache_(fetcher_.cache());
    on_end_(std::move(end));
    lock.lock();
  }
}

PrepareEnd Preparer::prepare(const PrepareOrder& order, const std::stop_token& stop) {
  std::string step = "fetch";
  PrepareEnd end;
  try {
    end.scene = build(order, stop, step);
  } catch (const FileNotHere& error) {
    end.code = "files";
    end.reason = error.what();
  } catch (const std::bad_alloc&) {
    end.code = "memory";
    end.reason = "there is not enough memory to build the scene";
  } catch (const std::exception& error) {
    end.code = step;
    end.reason = error.what();
  }
  if (stop.stop_requested()) end = {};
  return end;
}

std::shared_ptr<const PreparedScene> Preparer::build(const PrepareOrder& order,
                                                     const std::stop_token& stop,
                                                     std::string& step) {
  const JobSpec& spec = order.plan->spec;
  if (auto scene = built_.find(spec.bundle, spec.render)) {
    step = "scene";
    renderer_.check(*scene, spec);
    return scene;
  }
  // Neither memory nor the cache may have room for this one before.
  let_go_.wait_until_empty(stop);
  const auto began = std::chrono::steady_clock::now();
  auto fetched = fetcher_.fetch(
      spec.bundle, order.blob_url, order.blob_token,
      [this](double fraction) { on_progress_(0.5 * fraction); }, stop);
  if (!fetched) return nullptr;
  const auto fetched_at = std::chrono::steady_clock::now();
  step = "scene";
  const auto scene = renderer_.prepare(
      fetched->bundle, fetched->files, spec.render,
      [this](double fraction) { on_progress_(0.5 + 0.5 * fraction); }, stop);
  if (!scene) return nullptr;
  for (const SharedFile& file : fetched->shared) file.check_unchanged();
  renderer_.check(*scene, spec);
  log::info("job {}: {} files fetched in {:.3f} s, scene built in {:.3f} s", order.job.first,
            fetched->files.size(), seconds(fetched_at - began),
            seconds(std::chrono::steady_clock::now() - fetched_at));
  // The pins live as long as the scene: both hang on one count.
  const auto pinned = std::make_shared<const PinnedScene>(scene, std::move(*fetched));
  std::shared_ptr<const PreparedScene> shared(pinned, scene.get());
  built_.add(spec.bundle, shared);
  return shared;
}

}  // namespace tessera::agent
