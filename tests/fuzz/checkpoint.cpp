// A film's tile as a checkpoint holds it.
#include "server/film/film_tile_bytes.hpp"
#include "tests/fuzz/target.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tessera;
  const Rect window{.x = 8, .y = 4, .width = 4, .height = 3};
  fuzz::take_or_refuse([&] {
    const server::FilmTile tile =
        server::film_tile_from(fuzz::bytes_of(data, size), window, image::default_layout());
    fuzz::require(
        tile.window == window && tile.sums.size() == window.pixels() * image::channel_count,
        "a tile has the window that was asked for, and all its sums");
    (void)server::resolve(tile);
  });
  return 0;
}
