#pragma once
#include <filesystem>
#include <string_view>

#include "common/base/descriptor.hpp"

namespace tessera::client {

/// Bytes in memory under a path that this process can open like any file's, for as long as this
/// lives. Nothing is left of it, however the process ends.
class MemoryFile {
 public:
  /// Throws Error{failed} if there is no memory for it.
  explicit MemoryFile(std::string_view bytes);

  [[nodiscard]] std::filesystem::path path() const { return descriptor_.path(); }
  /// Whether a path is such a file's.
  [[nodiscard]] static bool is_one(const std::filesystem::path& path);

 private:
  Descriptor descriptor_;
};

}  // namespace tessera::client
