#include "server/coordinator/writer.hpp"

#include <algorithm>
#include <exception>

#include "common/base/log.hpp"

namespace tessera::server {

Writer::Writer(AppendGroup append, Hooks hooks, WriterSettings settings)
    : append_(std::move(append)),
      hooks_(std::move(hooks)),
      settings_(settings),
      thread_([this] { loop(); }) {}

Writer::~Writer() { stop(); }

void Writer::add(std::vector<ArrivedResult> results) {
  {
    const std::lock_guard lock(mutex_);
    for (ArrivedResult& result : results) queue_.emplace_back(std::move(result));
  }
  changed_.notify_one();
}

void Writer::run(std::function<void()> work) {
  {
    const std::lock_guard lock(mutex_);
    queue_.emplace_back(std::move(work));
  }
  changed_.notify_one();
}

void Writer::give_up() {
  {
    const std::lock_guard lock(mutex_);
    giving_up_ = true;
  }
  changed_.notify_all();
}

void Writer::stop() {
  {
    const std::lock_guard lock(mutex_);
    giving_up_ = true;
    stopping_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

std::vector<ArrivedResult> Writer::gather() {
  std::vector<ArrivedResult> group;
  std::size_t bytes = 0;
  while (!queue_.empty() && group.size() < settings_.group_results &&
         bytes < settings_.group_bytes) {
    auto* result = std::get_if<ArrivedResult>(&queue_.front());
    if (!result) break;
    bytes += result->exr->size();
    group.push_back(std::move(*result));
    queue_.pop_front();
  }
  return group;
}

void Writer::loop() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return stopping_ || !queue_.empty(); });
    if (queue_.empty()) return;
    if (auto* found = std::get_if<std::function<void()>>(&queue_.front())) {
      const std::function<void()> work = std::move(*found);
      queue_.pop_front();
      lock.unlock();
      work();
      lock.lock();
      continue;
    }
    std::vector<ArrivedResult> group = gather();
    lock.unlock();
    write(std::move(group));
    lock.lock();
  }
}

void Writer::write(std::vector<ArrivedResult> group) {
  Duration wait = settings_.retry_first;
  bool refused = false;
  for (;;) {
    try {
      const std::vector<ResultPlace> places = append_(group);
      for (std::size_t i = 0; i < group.size(); ++i) group[i].place = places[i];
      if (refused) hooks_.refused({});
      hooks_.committed(std::move(group));
      return;
    } catch (const std::exception& error) {
      log::error("{} results could not be kept; trying again in {:.1f} s: {}", group.size(),
                 seconds(wait), error.what());
      refused = true;
      hooks_.refused(error.what());
    }
    if (!pause(wait)) {
      log::warn("{} results are left to their workers: the disk refuses them", group.size());
      return;
    }
    wait = std::min(2 * wait, settings_.retry_most);
  }
}

bool Writer::pause(Duration wait) {
  const auto until = std::chrono::steady_clock::now() + wait;
  std::unique_lock lock(mutex_);
  for (;;) {
    auto work = queue_.end();
    const bool woken = changed_.wait_until(lock, until, [&] {
      work = std::find_if(queue_.begin(), queue_.end(), [](const Item& item) {
        return std::holds_alternative<std::function<void()>>(item);
      });
      return giving_up_ || work != queue_.end();
    });
    if (giving_up_) return false;
    if (!woken) return true;
    const auto todo = std::move(std::get<std::function<void()>>(*work));
    queue_.erase(work);
    lock.unlock();
    todo();
    lock.lock();
  }
}

}  // namespace tessera::server
