#pragma once
#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>

#include "common/base/descriptor.hpp"

namespace tessera::fuzz {

/// A file without a disk, for parsers that read files by name.
class MemoryFile {
 public:
  MemoryFile();

  void set(std::span<const std::byte> bytes);
  void set(std::string_view text);
  [[nodiscard]] std::filesystem::path path() const { return descriptor_.path(); }

 private:
  Descriptor descriptor_;
};

}  // namespace tessera::fuzz
