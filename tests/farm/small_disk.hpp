#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/farm/process.hpp"

/// A disk that really becomes full, or read-only.
namespace tessera::farm_test {

/// A tmpfs in a mount namespace of its own (and a user namespace, so that no privilege is needed):
/// programs that are started inside see it, nobody else does. Throws std::runtime_error where the
/// system does not allow such namespaces.
class SmallDisk {
 public:
  explicit SmallDisk(std::size_t bytes);

  /// Where it stands, for programs inside.
  [[nodiscard]] const std::filesystem::path& folder() const { return mount_.path(); }
  /// What stands before a program's command line to run it inside.
  [[nodiscard]] std::vector<std::string> inside() const;
  /// Takes all the room that is left.
  void fill() const;
  /// Gives it back.
  void make_room() const;
  /// From here on it can be read alone. Nobody may have a file of it open for writing.
  void forbid_writing() const { remount("remount,ro"); }
  void allow_writing() const { remount("remount,rw"); }

 private:
  [[nodiscard]] std::filesystem::path ballast() const;
  void remount(const std::string& options) const;

  TemporaryFolder logs_, mount_;
  Process holder_;
};

}  // namespace tessera::farm_test
