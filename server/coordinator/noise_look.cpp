#include "server/coordinator/noise_look.hpp"

#include <memory>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "server/coordinator/offload.hpp"
#include "server/film/noise.hpp"

namespace tessera::server {

boost::asio::awaitable<void> look_at_noise(Films& films, boost::asio::thread_pool& pool, JobId job,
                                           std::int32_t frame, std::function<void(double)> tell) {
  double noise = 0;
  try {
    FilmSnapshot snapshot = co_await films.snapshot(job, frame);
    const auto film = std::make_shared<const FilmSnapshot>(std::move(snapshot));
    const std::function<double()> measure = [film] { return noise_of(*film); };
    noise = co_await on<double>(pool, measure);
  } catch (const Error& error) {
    log::warn("job {} frame {}: its noise is not looked at: {}", job, frame, error.what());
    co_return;
  }
  log::debug("job {} frame {}: its noise is {:.5f}", job, frame, noise);
  tell(noise);
}

}  // namespace tessera::server
