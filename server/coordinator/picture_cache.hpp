#pragma once
#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <optional>

#include "server/coordinator/coordinator.hpp"

/// Encoded pictures: each version is encoded once, however many ask for it. Used on the I/O thread
/// alone.
namespace tessera::server {

struct PictureKey {
  enum class Form : std::uint8_t { exr, png, tiles };
  Form form = Form::exr;
  JobId job = 0;
  std::int32_t frame = 0;
  double exposure = 0;      ///< of a PNG, in stops
  std::uint64_t since = 0;  ///< of tiles
  auto operator<=>(const PictureKey&) const = default;
};

class PictureCache {
 public:
  /// Keeps at most `bytes_most` of pictures, those asked for last.
  PictureCache(boost::asio::any_io_executor executor, std::size_t bytes_most);
  ~PictureCache();

  /// Called once, on the I/O thread, with the picture or with what went wrong.
  using Done = std::function<void(std::exception_ptr, Picture)>;
  /// Begins to make the picture of the present version and returns; `done` is called later.
  using Make = std::function<void(Done done)>;

  /// The picture at version `at_least` or later. If one is being made that began before that
  /// version was there, waits for it and then has the next one made, for all who wait. Rethrows
  /// what went wrong.
  boost::asio::awaitable<Picture> get(PictureKey key, std::uint64_t at_least, Make make);

  /// Drops what is kept of the job.
  void forget(JobId job);
  [[nodiscard]] std::size_t bytes() const { return bytes_; }

 private:
  struct Flight;
  struct Entry {
    std::optional<Picture> picture;
    std::shared_ptr<Flight> flight;
    std::uint64_t used = 0;
  };

  std::shared_ptr<Flight> start(const PictureKey& key, const Make& make);
  void finish(const PictureKey& key, const std::shared_ptr<Flight>& flight,
              std::exception_ptr error, Picture picture);
  void trim();

  boost::asio::any_io_executor executor_;
  std::size_t bytes_most_;
  std::size_t bytes_ = 0;
  std::uint64_t clock_ = 0;
  std::map<PictureKey, Entry> entries_;
  std::shared_ptr<PictureCache*> self_;  ///< emptied when this dies: a flight may end later
};

}  // namespace tessera::server
