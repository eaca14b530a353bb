#pragma once
#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/base/limits.hpp"
#include "common/image/texels.hpp"
#include "common/scene/scene_file.hpp"

namespace tessera::client {

/// Looks at what a scene's pictures hold before anything is queued: a worker would find it, but
/// later and far away. Each picture is decoded once, however many scenes use it.
class Preflight {
 public:
  /// Throws one Error that lists all files which cannot be used, with the reasons: the scene's
  /// problems, and pictures that cannot be decoded.
  void check(const scene::LoadedScene& loaded);
  /// Of the pictures that were checked, decoded.
  [[nodiscard]] std::uint64_t decoded_bytes() const { return decoded_bytes_; }

 private:
  std::set<std::pair<std::filesystem::path, std::uint64_t>> seen_;  ///< file, place in it
  image::TexelBudget budget_{limits::images_bytes};
  std::uint64_t decoded_bytes_ = 0;
};

}  // namespace tessera::client
