#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/image/picture.hpp"
#include "common/image/tile.hpp"
#include "common/job/tile_grid.hpp"
#include "server/film/film_tile.hpp"

/// What a frame has gathered so far, and how it is looked at. Pure: no thread, no file.
namespace tessera::server {

/// A film as it stood at one version. Its tiles never change, so that any thread may read it while
/// the film goes on.
struct FilmSnapshot {
  TileGrid grid;
  std::uint64_t version = 0;
  std::vector<std::shared_ptr<const FilmTile>>
      tiles;  ///< by index in the grid; nullptr where nothing has arrived
  std::vector<std::uint64_t>
      versions;  ///< the film's version when each tile changed last; 0: never
  image::Layout layout = image::default_layout();
};

/// The film of one frame. Its version grows by one with every change. Tiles are copied on write: a
/// snapshot costs a pointer a tile. One thread at a time.
class Film {
 public:
  /// Empty. `version` is where counting goes on after a start: at least the last version that
  /// anyone was told.
  explicit Film(const TileGrid& grid, std::uint64_t version = 0,
                image::Layout layout = image::default_layout());

  [[nodiscard]] const TileGrid& grid() const { return grid_; }
  [[nodiscard]] std::uint64_t version() const { return version_; }
  /// Passes folded into a tile: the next one that it takes.
  [[nodiscard]] std::uint32_t passes(std::uint32_t tile) const;
  /// The tile as it stands, nullptr where nothing has arrived; it will not change.
  [[nodiscard]] std::shared_ptr<const FilmTile> tile(std::uint32_t tile);

  /// Folds the result of pass passes(tile) in.
  void fold(std::uint32_t tile, const image::TileImage& pass);
  /// Puts a tile in that was folded elsewhere (on a pool's thread, by folded()).
  void put(std::uint32_t tile, std::shared_ptr<const FilmTile> folded);
  /// Lends the tile's sums out, to be folded into elsewhere without a copy; give_back() must
  /// follow, and before it the film must neither be looked at nor changed at this tile, and no
  /// snapshot be taken. nullptr, and nothing is lent, if somebody else may hold the tile, or
  /// nothing has arrived.
  [[nodiscard]] std::shared_ptr<FilmTile> lend(std::uint32_t tile);
  /// Puts a tile in, lent or new, that nobody else holds.
  void give_back(std::uint32_t tile, std::shared_ptr<FilmTile> folded);
  /// Puts a tile back that was read from the store. The version stays; the tile counts as changed
  /// at it, or when it was before unload().
  void restore(std::uint32_t tile, std::shared_ptr<const FilmTile> stored);
  /// Lets go of a tile that is not lent: it will be restored. Snapshots keep theirs.
  void unload(std::uint32_t tile);

  [[nodiscard]] FilmSnapshot snapshot();

 private:
  struct Slot {
    std::shared_ptr<const FilmTile> tile;
    std::shared_ptr<FilmTile> own;  ///< the same tile while nobody else has been given it
    std::uint64_t version = 0;
  };

  TileGrid grid_;
  std::uint64_t version_ = 0;
  image::Layout layout_;
  std::vector<Slot> slots_;
};

/// A copy of `before` (nullptr: nothing yet) with the pass folded in; leaves `before` as it is. Any
/// thread.
std::shared_ptr<const FilmTile> folded(const FilmTile* before, const image::TileImage& pass);

/// A snapshot's rows, each tile by its own n; where nothing has arrived 0 (alpha too; Z
/// nothing_hit_z). The snapshot must outlive it.
class FilmRows : public image::FrameRows {
 public:
  explicit FilmRows(const FilmSnapshot& film) : film_(film) {}
  [[nodiscard]] int film_width() const override { return film_.grid.film_width(); }
  [[nodiscard]] int film_height() const override { return film_.grid.film_height(); }
  [[nodiscard]] Rect window() const override { return film_.grid.window(); }
  [[nodiscard]] const image::ChannelLayout& layout() const override { return *film_.layout; }
  void values(std::size_t channel, int y, std::span<float> row) const override;
  void samples(int y, std::span<std::uint32_t> row) const override;

 private:
  template <class Visit>
  void each_tile(int y, Visit visit) const;
  const FilmSnapshot& film_;
};

/// All that was rendered of the frame in memory, all channels, as FilmRows gives it.
image::FrameImage resolve(const FilmSnapshot& film);
/// R, G, B and A alone, four planes: what a PNG or a preview shows.
std::vector<float> resolve_rgba(const FilmSnapshot& film);

/// Indices of the tiles that changed after version `since`, ascending.
std::vector<std::uint32_t> changed_since(const FilmSnapshot& film, std::uint64_t since);
/// Those tiles in the binary form that README.md describes: a JSON header and half-float RGBA.
std::vector<std::byte> encode_changed_tiles(const FilmSnapshot& film, std::uint64_t since);

}  // namespace tessera::server
