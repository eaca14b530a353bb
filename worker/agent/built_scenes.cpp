#include "worker/agent/built_scenes.hpp"

namespace tessera::agent {

std::shared_ptr<const PreparedScene> BuiltScenes::find(const Digest& bundle,
                                                       const RenderSettings& settings) {
  std::erase_if(scenes_, [](const auto& entry) { return entry.second.expired(); });
  const auto [first, end] = scenes_.equal_range(bundle);
  for (auto at = first; at != end; ++at)
    if (auto scene = at->second.lock(); scene && scene->serves(settings)) return scene;
  return nullptr;
}

void BuiltScenes::add(const Digest& bundle, const std::shared_ptr<const PreparedScene>& scene) {
  scenes_.emplace(bundle, scene);
}

}  // namespace tessera::agent
