#pragma once
#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>

namespace tessera::fuzz {

/// A file without a disk, for parsers that read files by name.
class MemoryFile {
 public:
  MemoryFile();
  ~MemoryFile();
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  void set(std::span<const std::byte> bytes);
  void set(std::string_view text);
  [[nodiscard]] std::filesystem::path path() const;

 private:
  int descriptor_;
};

}  // namespace tessera::fuzz
