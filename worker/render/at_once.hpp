#pragma once
#include <cstddef>

namespace tessera::render {

/// So many samples go side by side at the most: while one waits for memory, others are at work, and
/// their arithmetic shares the lanes of registers. tests/bench/README.md has what was measured.
inline constexpr std::size_t samples_at_once = 64;

}  // namespace tessera::render
