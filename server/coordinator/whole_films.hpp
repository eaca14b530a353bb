#pragma once
#include <cstdint>
#include <memory>
#include <utility>

#include "server/coordinator/budget.hpp"
#include "server/coordinator/crew.hpp"
#include "server/film/film.hpp"

/// Memory for films that are held whole while they are written or looked at: many frames may end at
/// once. Used on the I/O thread alone.
namespace tessera::server {

class WholeFilms {
 public:
  /// `most`: bytes. `changed` is notified when a share ends.
  WholeFilms(std::uint64_t most, Signal& changed) : most_(most), changed_(changed) {}

  /// It counts until the last copy of it is gone, or the films are.
  using Share = std::shared_ptr<void>;
  /// Nothing if it does not fit now. One always does, however large.
  [[nodiscard]] Share take(std::uint64_t bytes) {
    if (*used_ > 0 && *used_ + bytes > most_) return nullptr;
    *used_ += bytes;
    return {used_.get(), [this, used = std::weak_ptr(used_), bytes](void*) {
              const auto still = used.lock();
              if (!still) return;  // the coordinator is destroyed before its coroutines
              *still -= bytes;
              changed_.notify();
            }};
  }
  [[nodiscard]] std::uint64_t used() const { return *used_; }

 private:
  std::uint64_t most_;
  Signal& changed_;
  std::shared_ptr<std::uint64_t> used_ = std::make_shared<std::uint64_t>(0);
};

/// A finished frame's film on its way to its checkpoint: of the frames whose film is at hand.
struct WholeFilm {
  std::shared_ptr<const FilmSnapshot> pixels;  ///< nullptr: on disk alone
  WholeFilms::Share share;
  std::shared_ptr<void> counted;  ///< in StorageUse::films

  void let_go() {
    pixels.reset();
    share.reset();
    counted.reset();
  }
};

}  // namespace tessera::server
