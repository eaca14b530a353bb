#pragma once
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "worker/agent/agent_state.hpp"
#include "worker/agent/built_scenes.hpp"
#include "worker/agent/fetch.hpp"
#include "worker/agent/renderer.hpp"
#include "worker/agent/scene_bin.hpp"

/// The thread that fetches and builds scenes, and the one that frees them.
namespace tessera::agent {

/// How a scene's preparation ended: with a scene, a failure, or neither where it was stopped.
struct PrepareEnd {
  std::shared_ptr<const PreparedScene> scene;
  std::string code;  ///< "fetch", "files", "scene" or "memory"; empty: no failure
  std::string reason;
};

/// One scene at a time. Two jobs with the same bundle share one scene if it serves both. Functions
/// are thread-safe; callbacks come from its thread.
class Preparer {
 public:
  using OnEnd = std::function<void(PrepareEnd)>;
  using OnCache = std::function<void(const wire::CacheUse&)>;
  /// `on_cache` is told at the start and after each preparation.
  Preparer(TaskRenderer& renderer, Fetcher& fetcher, OnEnd on_end, Fraction on_progress,
           OnCache on_cache);
  /// Stops, and waits.
  ~Preparer();
  Preparer(const Preparer&) = delete;
  Preparer& operator=(const Preparer&) = delete;

  /// Only after the end of the one before.
  void begin(PrepareOrder order);
  void stop();
  /// Lets go of scenes without waiting for it. None is built before they are gone.
  void let_go(std::vector<std::shared_ptr<const PreparedScene>> scenes);

 private:
  void work();
  PrepareEnd prepare(const PrepareOrder& order, const std::stop_token& stop);
  std::shared_ptr<const PreparedScene> build(const PrepareOrder& order, const std::stop_token& stop,
                                             std::string& step);

  TaskRenderer& renderer_;
  Fetcher& fetcher_;
  OnEnd on_end_;
  Fraction on_progress_;
  OnCache on_cache_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool ending_ = false;
  std::optional<PrepareOrder> next_;
  std::stop_source stop_{std::nostopstate};
  BuiltScenes built_;  ///< of this thread alone
  SceneBin let_go_;
  std::thread thread_;
};

}  // namespace tessera::agent
