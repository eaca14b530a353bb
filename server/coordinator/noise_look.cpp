#include "server/coordinator/noise_look.hpp"

#include <memory>

#include "common/base/log.hpp"
#include "server/coordinator/offload.hpp"
#include "server/coordinator/retry.hpp"

namespace tessera::server {

boost::asio::awaitable<void> NoiseLooks::look(NoiseLook look) {
  for (Duration wait = retry_first; !crew_.stopping() && look.wanted(); wait = longer(wait)) {
    const std::optional<double> noise = co_await measured(look);
    if (noise && !look.wanted()) co_return;
    if (noise) {
      log::debug("job {} frame {}: its noise is {:.5f}", look.job, look.frame, *noise);
      co_return look.tell(*noise);
    }
    co_await crew_.pause(wait);
  }
}

boost::asio::awaitable<std::optional<double>> NoiseLooks::measured(const NoiseLook& look) {
  WholeFilms::Share share;
  while (!crew_.stopping() && look.wanted() && !(share = whole_.take(look.bytes)))
    co_await changed_.wait();
  if (!share) co_return std::nullopt;
  try {
    FilmSnapshot snapshot = co_await films_.snapshot(look.job, look.frame);
    const auto film = std::make_shared<const FilmSnapshot>(std::move(snapshot));
    const std::function<double()> measure = [this, film] { return measure_(*film); };
    co_return co_await on<double>(pool_, measure);
  } catch (const std::exception& error) {
    if (look.wanted())
      log::error("job {} frame {}: its noise could not be measured: {}", look.job, look.frame,
                 error.what());
  }
  co_return std::nullopt;
}

}  // namespace tessera::server
