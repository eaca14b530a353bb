#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

/// A scene whose files are as many and as large as a test wants.
namespace tessera::farm_test {

struct LargeSceneSettings {
  int pictures = 1;
  int side = 512;  ///< of each, pixels; three bytes each
};

/// A sphere for each picture, which is its texture: an uncompressed TGA that takes no room on the
/// disk. Its film is 16 by 16, one sample a pixel.
class LargeScene {
 public:
  LargeScene(const std::filesystem::path& folder, const LargeSceneSettings& settings);

  [[nodiscard]] std::string file() const { return (folder_ / "scene.json").string(); }
  [[nodiscard]] std::filesystem::path picture(int index) const;
  /// Of all files.
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

 private:
  std::filesystem::path folder_;
  std::uint64_t bytes_ = 0;
};

}  // namespace tessera::farm_test
