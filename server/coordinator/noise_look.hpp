#pragma once
#include <boost/asio/awaitable.hpp>
#include <boost/asio/thread_pool.hpp>
#include <cstdint>
#include <functional>
#include <optional>

#include "server/coordinator/films.hpp"
#include "server/coordinator/whole_films.hpp"
#include "server/film/noise.hpp"

namespace tessera::server {

/// A frame whose noise somebody waits for.
struct NoiseLook {
  JobId job = 0;
  std::int32_t frame = 0;
  std::uint64_t bytes = 0;           ///< of memory that its film and the look take
  std::function<bool()> wanted;      ///< false: nobody waits any more
  std::function<void(double)> tell;  ///< called once, unless it is not wanted
};

/// Takes the noise of films as they stand, on the pool. Used on the I/O thread alone.
class NoiseLooks {
 public:
  using Measure = std::function<double(const FilmSnapshot&)>;
  /// A film that is looked at counts among `whole`; `changed` is notified when there is more room.
  NoiseLooks(Films& films, WholeFilms& whole, Signal& changed, Crew& crew,
             boost::asio::thread_pool& pool, Measure measure = noise_of)
      : films_(films),
        whole_(whole),
        changed_(changed),
        crew_(crew),
        pool_(pool),
        measure_(std::move(measure)) {}

  /// What fails is tried again, with pauses that double, for as long as it is wanted and the crew
  /// does not stop: its frame goes on by the answer alone.
  boost::asio::awaitable<void> look(NoiseLook look);

 private:
  /// Nothing if it failed, or is not wanted.
  boost::asio::awaitable<std::optional<double>> measured(const NoiseLook& look);

  Films& films_;
  WholeFilms& whole_;
  Signal& changed_;
  Crew& crew_;
  boost::asio::thread_pool& pool_;
  Measure measure_;
};

}  // namespace tessera::server
