#pragma once
#include <map>
#include <memory>

#include "common/base/digest.hpp"
#include "worker/agent/renderer.hpp"

namespace tessera::agent {

/// Scenes that were built, as long as someone has them, so that jobs share them. Of one thread.
class BuiltScenes {
 public:
  /// One of this bundle that serves a job with these settings; empty if none is there.
  [[nodiscard]] std::shared_ptr<const PreparedScene> find(const Digest& bundle,
                                                          const RenderSettings& settings);
  void add(const Digest& bundle, const std::shared_ptr<const PreparedScene>& scene);

 private:
  std::multimap<Digest, std::weak_ptr<const PreparedScene>> scenes_;  ///< by bundle
};

}  // namespace tessera::agent
