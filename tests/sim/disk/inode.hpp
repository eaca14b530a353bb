#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tests/sim/events.hpp"

/// One file's bytes: as programs see them, and as they would be found after a power cut.
namespace tessera::sim {

constexpr std::uint64_t sector_bytes = 512;

/// What becomes of that which was not synced when the power goes.
struct CutWeather {
  enum class Kind {
    lost,      ///< all of it
    kept,      ///< nothing of it is lost
    in_order,  ///< the first so many changes are kept, the last of them torn between two sectors
    any,       ///< any set of sectors, of any of the changes
  };
  Kind kind = Kind::lost;
  double kept = 0.5;     ///< chance of a sector, or share of the changes
  bool garbage = false;  ///< what is within a file's length and was never written is not zero
};

class Inode {
 public:
  [[nodiscard]] const std::vector<std::byte>& bytes() const { return now_; }
  void write(std::uint64_t offset, std::span<const std::byte> bytes);
  void truncate(std::uint64_t size);
  void sync();
  /// A sync that failed: some sectors are kept; the others are forgotten, as Linux does: programs
  /// still see them, and no later sync brings them to the disk.
  void fail_sync(Random& random);
  /// What is found after the power came back. Gives how many sectors were lost.
  std::uint64_t cut(const CutWeather& weather, Random& random);

 private:
  struct Change {
    bool cuts = false;  // the file's length to `offset`
    std::uint64_t offset = 0;
    std::vector<std::byte> bytes;
  };
  static void apply(std::vector<std::byte>& to, const Change& change);
  /// Those of the change's sectors for which `keep` says so. Gives how many were not kept.
  template <class Keep>
  std::uint64_t apply_some(const Change& change, Keep keep);

  std::vector<std::byte> now_, safe_;
  std::vector<Change> unsynced_;
};

}  // namespace tessera::sim
