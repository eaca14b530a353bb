#pragma once
#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/scene/description.hpp"

namespace tessera::client {

/// Looks at what a scene's pictures hold before anything is queued: a worker would find it, but
/// later and far away. Each picture is decoded once, however many scenes use it.
class Preflight {
 public:
  /// Throws Error{bad_input} that lists all pictures that cannot be decoded, with the reasons.
  void check_pictures(const scene::Scene& scene);

 private:
  std::set<std::pair<std::filesystem::path, std::uint64_t>> seen_;  ///< file, place in it
};

}  // namespace tessera::client
