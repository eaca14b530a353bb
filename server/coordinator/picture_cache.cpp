#include "server/coordinator/picture_cache.hpp"

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>

#include "common/base/error.hpp"

namespace tessera::server {

/// One making of one picture, and those who wait for it.
struct PictureCache::Flight {
  explicit Flight(const boost::asio::any_io_executor& executor)
      : landed(executor, boost::asio::steady_timer::time_point::max()) {}
  bool done = false;
  std::exception_ptr error;
  Picture picture;
  boost::asio::steady_timer landed;
};

PictureCache::PictureCache(boost::asio::any_io_executor executor, std::size_t bytes_most)
    : executor_(std::move(executor)),
      bytes_most_(bytes_most),
      self_(std::make_shared<PictureCache*>(this)) {}

PictureCache::~PictureCache() { *self_ = nullptr; }

boost::asio::awaitable<Picture> PictureCache::get(PictureKey key, std::uint64_t at_least,
                                                  Make make) {
  for (;;) {
    Entry& entry = entries_[key];
    entry.used = ++clock_;
    if (entry.picture && entry.picture->version >= at_least) co_return *entry.picture;
    const bool mine = !entry.flight;
    const std::shared_ptr<Flight> flight = mine ? start(key, make) : entry.flight;
    if (!flight->done)
      co_await flight->landed.async_wait(boost::asio::as_tuple(boost::asio::use_awaitable));
    if (!flight->done)
      throw Error(ErrorKind::failed, "the coordinator stopped before the picture was made");
    const bool serves = mine || flight->picture.version >= at_least;
    if (serves && flight->error) std::rethrow_exception(flight->error);
    if (serves) co_return flight->picture;
  }
}

std::shared_ptr<PictureCache::Flight> PictureCache::start(const PictureKey& key, const Make& make) {
  auto flight = std::make_shared<Flight>(executor_);
  entries_[key].flight = flight;
  make([self = self_, key, flight](std::exception_ptr error, Picture picture) {
    if (*self) (*self)->finish(key, flight, std::move(error), std::move(picture));
  });
  return flight;
}

void PictureCache::finish(const PictureKey& key, const std::shared_ptr<Flight>& flight,
                          std::exception_ptr error, Picture picture) {
  flight->done = true;
  flight->error = std::move(error);
  flight->picture = picture;
  flight->landed.cancel();
  const auto found = entries_.find(key);
  if (found == entries_.end() || found->second.flight != flight) return;  // forgotten meanwhile
  Entry& entry = found->second;
  entry.flight.reset();
  if (flight->error) return;
  if (entry.picture) bytes_ -= entry.picture->bytes->size();
  bytes_ += picture.bytes->size();
  entry.picture = std::move(picture);
  trim();
}

void PictureCache::trim() {
  while (bytes_ > bytes_most_ || entries_.size() > 4096) {
    auto oldest = entries_.end();
    for (auto it = entries_.begin(); it != entries_.end(); ++it)
      if (!it->second.flight && (oldest == entries_.end() || it->second.used < oldest->second.used))
        oldest = it;
    if (oldest == entries_.end()) return;
    if (oldest->second.picture) bytes_ -= oldest->second.picture->bytes->size();
    entries_.erase(oldest);
  }
}

void PictureCache::forget(JobId job) {
  std::erase_if(entries_, [&](const auto& item) {
    if (item.first.job != job) return false;
    if (item.second.picture) bytes_ -= item.second.picture->bytes->size();
    return true;
  });
}

}  // namespace tessera::server
