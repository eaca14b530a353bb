#pragma once
#include <filesystem>

namespace tessera::client {

/// A temporary folder that goes with this object. One that a process left because it was killed is
/// removed by the next that makes one: whoever has such a folder holds a lock in it, which the
/// kernel gives back when the process ends.
class ScratchFolder {
 public:
  /// Below `root`, or where temporary files belong. Throws Error{failed}.
  explicit ScratchFolder(const std::filesystem::path& root = {});
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  int lock_ = -1;
};

}  // namespace tessera::client
