#pragma once
#include <cstdint>
#include <span>
#include <vector>

/// Which films leave memory, and which go to disk. Pure.
namespace tessera::server {

/// True if a checkpoint should take the place of so many bytes of the journal: a film's own bytes
/// are what it costs.
bool worth_a_checkpoint(std::uint64_t journal, std::uint64_t film);

struct FilmUse {
  std::uint64_t bytes = 0;  ///< in memory
  std::uint64_t used = 0;   ///< when it was used last: larger is later
  bool held = false;        ///< it must stay
};

/// The films to be dropped, by index: none while all of them fit `most`; else those that were used
/// longest ago, until three quarters of it are left. So before the next has to go a quarter of the
/// memory is read back, and what little was read back for one is not dropped for another at once.
std::vector<std::size_t> films_to_drop(std::span<const FilmUse> films, std::uint64_t most);

}  // namespace tessera::server
