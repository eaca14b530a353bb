#pragma once
#include <cstddef>

/// How long texts are that messages hold: what is written is cut to it, what is read is held to it.
namespace tessera::wire {

constexpr std::size_t reason_most = 2048;  ///< bytes of a sentence for people
constexpr std::size_t log_most = 8192;     ///< of a worker's log
constexpr std::size_t short_most = 512;  ///< of one that must fit into 4 KiB however it is escaped

}  // namespace tessera::wire
