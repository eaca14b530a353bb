#include "worker/agent/scene_bin.hpp"

#include <iterator>
#include <utility>

namespace tessera::agent {

SceneBin::SceneBin() : thread_([this] { work(); }) {}

SceneBin::~SceneBin() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void SceneBin::put(std::vector<std::shared_ptr<const PreparedScene>> scenes) {
  if (scenes.empty()) return;
  {
    const std::lock_guard lock(mutex_);
    std::move(scenes.begin(), scenes.end(), std::back_inserter(scenes_));
  }
  wake_.notify_all();
}

void SceneBin::wait_until_empty(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  emptied_.wait(lock, stop, [this] { return scenes_.empty() && !freeing_; });
}

void SceneBin::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return !scenes_.empty() || ending_; });
    if (scenes_.empty()) return;
    std::vector<std::shared_ptr<const PreparedScene>> scenes = std::exchange(scenes_, {});
    freeing_ = true;
    lock.unlock();
    scenes.clear();
    lock.lock();
    freeing_ = false;
    emptied_.notify_all();
  }
}

}  // namespace tessera::agent
