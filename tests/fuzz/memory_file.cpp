#include "tests/fuzz/memory_file.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include "tests/fuzz/target.hpp"

namespace tessera::fuzz {

MemoryFile::MemoryFile() : descriptor_(memfd_create("input", MFD_CLOEXEC)) {
  require(descriptor_.is_open(), "a file in memory can be made");
}

void MemoryFile::set(std::span<const std::byte> bytes) {
  require(ftruncate(descriptor_.number(), 0) == 0, "a file in memory can be emptied");
  const auto written = pwrite(descriptor_.number(), bytes.data(), bytes.size(), 0);
  require(written == static_cast<ssize_t>(bytes.size()), "a file in memory takes all bytes");
}

void MemoryFile::set(std::string_view text) { set(std::as_bytes(std::span(text))); }

}  // namespace tessera::fuzz
