#include "server/coordinator/film_memory.hpp"

#include <algorithm>

namespace tessera::server {

bool worth_a_checkpoint(std::uint64_t journal, std::uint64_t film) {
  constexpr std::uint64_t films = 2;
  return journal > films * film;
}

std::vector<std::size_t> films_to_drop(std::span<const FilmUse> films, std::uint64_t most) {
  std::uint64_t total = 0;
  std::vector<std::size_t> candidates, dropped;
  for (std::size_t i = 0; i < films.size(); ++i) {
    total += films[i].bytes;
    if (!films[i].held && films[i].bytes > 0) candidates.push_back(i);
  }
  if (total <= most) return dropped;
  std::stable_sort(candidates.begin(), candidates.end(),
                   [&](std::size_t a, std::size_t b) { return films[a].used < films[b].used; });
  const std::uint64_t enough = most - most / 4;
  for (const std::size_t i : candidates) {
    if (total <= enough) break;
    // The one that is in use now stays if it fits by itself.
    if (i == candidates.back() && total <= most) break;
    total -= films[i].bytes;
    dropped.push_back(i);
  }
  return dropped;
}

}  // namespace tessera::server
