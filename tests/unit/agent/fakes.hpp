#pragma once
#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "common/base/error.hpp"
#include "common/job/job_spec.hpp"
#include "worker/agent/renderer.hpp"

/// What the agent's tests share.
namespace tessera::agent {

inline JobSpec test_spec(const Digest& bundle = digest_of("bundle"), int tile = 16,
                         std::int64_t samples = 4) {
  JobSpec spec;
  spec.name = "test";
  spec.bundle = bundle;
  spec.render.width = 64;
  spec.render.height = 48;
  spec.render.samples = samples;
  spec.tile = tile;
  return spec;
}

/// Serves all jobs, or those that do not ask for UV.
class FakeScene : public PreparedScene {
 public:
  explicit FakeScene(
      bool coordinates = true, std::function<void()> on_freed = [] {})
      : coordinates_(coordinates), on_freed_(std::move(on_freed)) {}
  ~FakeScene() override { on_freed_(); }
  FakeScene(const FakeScene&) = delete;
  FakeScene& operator=(const FakeScene&) = delete;
  bool serves(const RenderSettings& settings) const override {
    const auto& aovs = settings.aovs;
    return coordinates_ || std::find(aovs.begin(), aovs.end(), "UV") == aovs.end();
  }

 private:
  bool coordinates_;
  std::function<void()> on_freed_;
};

/// Tiles of zeros, as slowly as asked. While `hold` is set, renders wait for it or for their stop.
class FakeRenderer : public TaskRenderer {
 public:
  explicit FakeRenderer(int count = 1) : threads_(count) {}

  Digest build_id() const override { return digest_of("fake"); }
  int threads() const override { return threads_; }

  std::shared_ptr<const PreparedScene> prepare(const assets::Bundle&, const SceneFiles& files,
                                               const RenderSettings&, const Fraction& progress,
                                               std::stop_token stop) override {
    ++prepared;
    last_files = files;
    progress(0.5);
    while (hold_prepare && !stop.stop_requested())
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    if (stop.stop_requested()) return nullptr;
    if (!prepare_error.empty()) throw Error(ErrorKind::bad_input, prepare_error);
    return std::make_shared<const FakeScene>(true, on_freed);
  }
  void check(const PreparedScene&, const JobSpec& spec) const override {
    if (spec.camera == "none") throw Error(ErrorKind::bad_input, "unknown camera \"none\"");
  }
  std::optional<RenderedTile> render(const PreparedScene&, const JobSpec& spec,
                                     const RenderRequest& request, const Fraction& progress,
                                     std::stop_token stop) override {
    const int now_active = ++active;
    int most = most_active;
    while (now_active > most && !most_active.compare_exchange_weak(most, now_active)) {
    }
    {
      const std::lock_guard lock(mutex);
      order.push_back(request.window);
    }
    progress(0.5);
    const auto end = std::chrono::steady_clock::now() + delay;
    while ((hold || std::chrono::steady_clock::now() < end) && !stop.stop_requested())
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    --active;
    if (stop.stop_requested()) return std::nullopt;
    if (!render_error.empty()) throw Error(ErrorKind::failed, render_error);
    RenderedTile tile;
    tile.image.window = request.window;
    tile.image.film_width = spec.render.width;
    tile.image.film_height = spec.render.height;
    tile.image.samples = {static_cast<std::uint32_t>(request.samples.count),
                          request.aovs ? static_cast<std::uint32_t>(request.samples.count) : 0U};
    tile.image.values.resize(tile.image.channels() * tile.image.pixels());
    tile.samples = request.window.pixels() * request.samples.count;
    tile.rays = 3;
    return tile;
  }

  std::atomic<bool> hold = false, hold_prepare = false;
  std::chrono::microseconds delay{0};
  std::string prepare_error, render_error;
  std::function<void()> on_freed = [] {};  ///< of its scenes, by whoever was the last to have one
  std::atomic<int> prepared = 0, active = 0, most_active = 0;
  SceneFiles last_files;
  std::mutex mutex;
  std::vector<Rect> order;

 private:
  int threads_;
};

}  // namespace tessera::agent
