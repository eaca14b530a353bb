#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <utility>

#include "common/scene/scene_file.hpp"

namespace tessera::client {

struct OverlaidFile {
  std::filesystem::path file;
  std::string shown = {};  ///< in errors; empty: as a file of the folder
};

/// A scene's folder in which other files stand for some, or beside them.
class OverlayFiles : public scene::SceneFiles {
 public:
  /// `over`: path in the scene, checked_path's spelling → the file on this machine.
  OverlayFiles(const std::filesystem::path& folder, std::map<std::string, OverlaidFile> over)
      : folder_(folder), over_(std::move(over)) {}
  [[nodiscard]] std::filesystem::path locate(const std::string& path) const override {
    const auto found = over_.find(scene::checked_path(path));
    return found != over_.end() ? found->second.file : folder_.locate(path);
  }
  [[nodiscard]] std::string shown(const std::string& path) const override {
    const auto found = over_.find(path);
    return found != over_.end() && !found->second.shown.empty() ? found->second.shown
                                                                : folder_.shown(path);
  }
  [[nodiscard]] const std::map<std::string, OverlaidFile>& over() const { return over_; }

 private:
  scene::FolderFiles folder_;
  std::map<std::string, OverlaidFile> over_;
};

}  // namespace tessera::client
