#include "server/film/film_tile_bytes.hpp"

#include <bit>
#include <cstdint>
#include <cstring>
#include <utility>

#include "common/base/error.hpp"

namespace tessera::server {

namespace {

static_assert(std::endian::native == std::endian::little);
constexpr std::uint32_t version = 1;

class Out {
 public:
  template <class T>
  void number(const T& value) {
    const auto* from = reinterpret_cast<const std::byte*>(&value);
    bytes_.insert(bytes_.end(), from, from + sizeof value);
  }
  void plane(std::span<const double> sums) {
    std::uint64_t used = 0;
    for (const double sum : sums) used |= std::bit_cast<std::uint64_t>(sum);
    const auto dropped =
        used == 0 ? sizeof(double) : static_cast<std::size_t>(std::countr_zero(used)) / 8;
    const std::size_t kept = sizeof(double) - dropped;
    number(static_cast<std::uint8_t>(kept));
    const std::size_t at = bytes_.size();
    bytes_.resize(at + kept * sums.size());
    if (kept == 0) return;
    std::byte* to = bytes_.data() + at;
    for (const double sum : sums) {
      const std::uint64_t upper = std::bit_cast<std::uint64_t>(sum) >> (8 * dropped);
      std::memcpy(to, &upper, kept);
      to += kept;
    }
  }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

[[noreturn]] void fail(const char* what) { throw Error(ErrorKind::failed, what); }

class In {
 public:
  explicit In(std::span<const std::byte> bytes) : bytes_(bytes) {}
  template <class T>
  T number() {
    T value{};
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    return value;
  }
  void plane(std::span<double> sums) {
    const std::size_t kept = number<std::uint8_t>();
    if (kept > sizeof(double)) fail("a stored tile of a film has sums of another size");
    const std::span<const std::byte> plane = take(kept * sums.size());
    if (kept == 0) return;  // they are 0
    const std::byte* from = plane.data();
    for (double& sum : sums) {
      std::uint64_t upper = 0;
      std::memcpy(&upper, from, kept);
      sum = std::bit_cast<double>(upper << (8 * (sizeof(double) - kept)));
      from += kept;
    }
  }
  [[nodiscard]] bool at_end() const { return bytes_.empty(); }

 private:
  std::span<const std::byte> take(std::size_t size) {
    if (size > bytes_.size()) fail("a stored tile of a film is shorter than it says");
    const auto piece = bytes_.first(size);
    bytes_ = bytes_.subspan(size);
    return piece;
  }
  std::span<const std::byte> bytes_;
};

}  // namespace

std::vector<std::byte> bytes_of(const FilmTile& tile) {
  Out out;
  out.number(version);
  for (const int value : {tile.window.x, tile.window.y, tile.window.width, tile.window.height})
    out.number(static_cast<std::int32_t>(value));
  out.number(tile.passes);
  out.number(static_cast<std::uint32_t>(image::group_count));
  for (const std::uint64_t samples : tile.samples) out.number(samples);
  out.number(static_cast<std::uint32_t>(tile.layout->size()));
  for (std::size_t c = 0; c < tile.layout->size(); ++c)
    out.plane(std::span(tile.sums).subspan(c * tile.pixels(), tile.pixels()));
  return out.take();
}

FilmTile film_tile_from(std::span<const std::byte> bytes, const Rect& window,
                        image::Layout layout) {
  In in(bytes);
  if (in.number<std::uint32_t>() != version) fail("a stored tile of a film is of another version");
  for (const int value : {window.x, window.y, window.width, window.height})
    if (in.number<std::int32_t>() != value)
      fail("a stored tile of a film is not the one that was asked for");
  FilmTile tile;
  tile.window = window;
  tile.passes = in.number<std::uint32_t>();
  if (in.number<std::uint32_t>() != image::group_count)
    fail("a stored tile of a film has other groups of channels");
  for (std::uint64_t& samples : tile.samples) samples = in.number<std::uint64_t>();
  if (in.number<std::uint32_t>() != layout->size())
    fail("a stored tile of a film has other channels");
  tile.layout = std::move(layout);
  tile.sums.assign(tile.layout->size() * tile.pixels(), 0.0);
  for (std::size_t c = 0; c < tile.layout->size(); ++c)
    in.plane(std::span(tile.sums).subspan(c * tile.pixels(), tile.pixels()));
  if (!in.at_end()) fail("a stored tile of a film is longer than it says");
  return tile;
}

}  // namespace tessera::server
