#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <string>
#include <string_view>

#include "tests/sim/events.hpp"

/// Where the simulated disk can fail, and how.
namespace tessera::sim {

/// What is done at a fault point. `commit`: a call of the store has come back, and nobody knows it
/// yet.
enum class Point {
  write,
  sync,
  truncate,
  create,
  remove,
  rename,
  make_folder,
  sync_folder,
  commit
};
constexpr std::size_t point_kinds = 9;
constexpr std::array<std::string_view, point_kinds> point_names{
    "write",  "sync",        "truncate",    "create", "remove",
    "rename", "make folder", "sync folder", "commit"};

/// What happens there. An error may come before, after or in the middle of what was to be done.
enum class Fault { none, error, full, kill, power };
constexpr std::size_t fault_kinds = 5;
constexpr std::array<std::string_view, fault_kinds> fault_names{"none", "I/O error", "disk full",
                                                                "kill", "power cut"};

/// How often; each a chance at one point.
struct FaultWeather {
  double error = 0;
  double full = 0;  ///< a write that finds no room
  double kill = 0;
  double power = 0;
  double spell = 0;             ///< chance that an error is the first of a spell of them
  std::optional<Point> only{};  ///< errors come at such points alone
};

/// Numbers the points of a run and says what happens at each: drawn, or at one number as told.
class Faults {
 public:
  explicit Faults(Random random) : random_(random) {}

  void set(const FaultWeather& weather) {
    weather_ = weather;
    spell_ = 0;
  }
  /// This fault at this point, once, whatever the weather.
  void at(std::uint64_t number, Fault fault) {
    told_at_ = number;
    told_ = fault;
  }
  Fault reach(Point point);

  [[nodiscard]] std::uint64_t points() const { return points_; }
  [[nodiscard]] std::uint64_t reached(Point point) const {
    return reached_.at(static_cast<std::size_t>(point));
  }
  [[nodiscard]] std::uint64_t happened(Fault fault) const {
    return happened_.at(static_cast<std::size_t>(fault));
  }
  /// All that went wrong so far.
  [[nodiscard]] std::uint64_t failures() const {
    return std::accumulate(happened_.begin() + 1, happened_.end(), std::uint64_t{0});
  }
  /// One that came from outside, between two points.
  void count(Fault fault) { ++happened_.at(static_cast<std::size_t>(fault)); }

 private:
  Fault draw(Point point);

  Random random_;
  FaultWeather weather_;
  std::uint64_t points_ = 0;
  std::int64_t spell_ = 0;  // errors that are still to come
  std::uint64_t told_at_ = 0;
  Fault told_ = Fault::none;
  std::array<std::uint64_t, point_kinds> reached_{};
  std::array<std::uint64_t, fault_kinds> happened_{};
};

/// One line of a trace.
std::string described(std::uint64_t number, Point point, Fault fault, const std::string& file);

}  // namespace tessera::sim
