#include "server/film/film.hpp"

#include <utility>

#include "common/base/error.hpp"

namespace tessera::server {

Film::Film(const TileGrid& grid, std::uint64_t version, image::Layout layout)
    : grid_(grid), version_(version), layout_(std::move(layout)), slots_(grid.count()) {}

std::uint32_t Film::passes(std::uint32_t tile) const {
  const auto& slot = slots_.at(tile);
  return slot.tile ? slot.tile->passes : 0;
}

std::shared_ptr<const FilmTile> Film::tile(std::uint32_t tile) {
  Slot& slot = slots_.at(tile);
  slot.own.reset();
  return slot.tile;
}

void Film::fold(std::uint32_t tile, const image::TileImage& pass) {
  Slot& slot = slots_.at(tile);
  if (!slot.own) {
    const Rect window = grid_.tile(tile);
    auto copy =
        std::make_shared<FilmTile>(slot.tile ? *slot.tile : empty_film_tile(window, layout_));
    server::fold(*copy, pass);
    slot.own = std::move(copy);
    slot.tile = slot.own;
  } else {
    server::fold(*slot.own, pass);
  }
  slot.version = ++version_;
}

void Film::put(std::uint32_t tile, std::shared_ptr<const FilmTile> folded) {
  restore(tile, std::move(folded));
  slots_[tile].version = ++version_;
}

void Film::restore(std::uint32_t tile, std::shared_ptr<const FilmTile> stored) {
  Slot& slot = slots_.at(tile);
  if (!stored || stored->window != grid_.tile(tile) || *stored->layout != *layout_ ||
      stored->sums.size() != layout_->size() * stored->pixels())
    throw Error(ErrorKind::failed, "a tile does not fit the film that it was to be put into");
  slot.tile = std::move(stored);
  slot.own.reset();
  if (slot.version == 0) slot.version = version_;
}

void Film::unload(std::uint32_t tile) {
  Slot& slot = slots_.at(tile);
  slot.tile.reset();
  slot.own.reset();
}

std::shared_ptr<FilmTile> Film::lend(std::uint32_t tile) {
  Slot& slot = slots_.at(tile);
  if (slot.own) slot.tile.reset();
  return std::move(slot.own);
}

void Film::give_back(std::uint32_t tile, std::shared_ptr<FilmTile> folded) {
  put(tile, folded);
  slots_[tile].own = std::move(folded);
}

FilmSnapshot Film::snapshot() {
  FilmSnapshot out{
      .grid = grid_, .version = version_, .tiles = {}, .versions = {}, .layout = layout_};
  out.tiles.reserve(slots_.size());
  out.versions.reserve(slots_.size());
  for (Slot& slot : slots_) {
    slot.own.reset();
    out.tiles.push_back(slot.tile);
    out.versions.push_back(slot.version);
  }
  return out;
}

std::shared_ptr<const FilmTile> folded(const FilmTile* before, const image::TileImage& pass) {
  auto after = std::make_shared<FilmTile>(
      before != nullptr ? *before : empty_film_tile(pass.window, pass.layout));
  fold(*after, pass);
  return after;
}

}  // namespace tessera::server
