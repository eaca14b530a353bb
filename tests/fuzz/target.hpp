#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string_view>

#include "common/base/error.hpp"
#include "common/base/names.hpp"

/// What the fuzz targets share. A target is one function, LLVMFuzzerTestOneInput, that gives a
/// parser any bytes; whoever calls it finds what crashes, hangs, leaks or takes too much memory.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace tessera::fuzz {

inline std::span<const std::byte> bytes_of(const std::uint8_t* data, std::size_t size) {
  return std::as_bytes(std::span(data, size));
}
inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// What must hold whatever the input was; else the process ends as by a crash.
inline void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "does not hold: %s\n", what);
  std::abort();
}

/// Parses. An input may be refused by an Error that says why in words that a terminal and a JSON
/// text can show, whatever bytes stood in the input, and by nothing else.
template <class Parse>
void take_or_refuse(const Parse& parse) {
  try {
    parse();
  } catch (const Error& error) {
    const std::string_view said = error.what();
    require(!error.message().empty(), "an error says why");
    require(is_utf8(said), "an error is UTF-8");
    require(std::none_of(said.begin(), said.end(),
                         [](unsigned char c) { return c < 0x20 || c == 0x7f; }),
            "an error has no control characters");
  }
}

}  // namespace tessera::fuzz
