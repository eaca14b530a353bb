#include "tests/sim/disk/faults.hpp"

#include <fmt/format.h>

namespace tessera::sim {

Fault Faults::reach(Point point) {
  ++points_;
  ++reached_.at(static_cast<std::size_t>(point));
  const Fault fault = points_ == told_at_ ? told_ : draw(point);
  if (fault != Fault::none) count(fault);
  return fault;
}

Fault Faults::draw(Point point) {
  const double drawn = random_.unit();
  double below = weather_.power;
  if (drawn < below) return Fault::power;
  below += weather_.kill;
  if (drawn < below) return Fault::kill;
  if (point == Point::commit) return Fault::none;  // it has come back: no error any more
  if (weather_.only && point != *weather_.only) return Fault::none;
  if (spell_ > 0) {
    --spell_;
    return Fault::error;
  }
  below += weather_.error;
  if (drawn < below) {
    if (random_.chance(weather_.spell)) spell_ = random_.whole(1, 30);
    return Fault::error;
  }
  below += weather_.full;
  return drawn < below && point == Point::write ? Fault::full : Fault::none;
}

std::string described(std::uint64_t number, Point point, Fault fault, const std::string& file) {
  std::string line =
      fmt::format("{:>6} {} {}", number, point_names.at(static_cast<std::size_t>(point)), file);
  if (fault != Fault::none)
    line += fmt::format(": {}", fault_names.at(static_cast<std::size_t>(fault)));
  return line;
}

}  // namespace tessera::sim
