#include "server/schedule/work_left.hpp"

#include <algorithm>
#include <cmath>

namespace tessera::server {

WorkLeft::WorkLeft(const JobPlan& plan) {
  const std::uint32_t tiles = plan.grid.count();
  while (tiles >> shift_ > places_most) ++shift_;
  places_.resize((tiles >> shift_) + 1);
  const std::int64_t samples = plan.passes.samples() * plan.spec.frames.count();
  for (std::uint32_t tile = 0; tile < tiles; ++tile)
    places_[tile >> shift_].pixels += plan.grid.tile(tile).pixels();
  for (Place& place : places_) place.left = place.pixels * samples;
  for (const Place& place : places_) unmeasured_left_ += static_cast<double>(place.left);
}

void WorkLeft::closed(std::uint32_t tile, std::int64_t samples) {
  Place& place = places_[tile >> shift_];
  place.left -= samples;
  const auto gone = static_cast<double>(samples);
  if (place.weight > 0) {
    measured_left_ -= place.cost * gone;
  } else {
    unmeasured_left_ -= gone;
  }
}

void WorkLeft::measured(std::uint32_t tile, std::int64_t samples, double work) {
  Place& place = places_[tile >> shift_];
  const auto count = static_cast<double>(samples);
  const double now = work / count;
  const auto left = static_cast<double>(place.left);
  if (place.weight > 0) {
    measured_left_ -= place.cost * left;
    measured_cost_ -= place.cost;
    measured_squares_ -= place.cost * place.cost;
  } else {
    unmeasured_left_ -= left;
    measured_places_ += 1;
  }
  // What comes last has most samples, and counts half at least.
  const double before = std::min(place.weight, count);
  place.cost = (place.cost * before + now * count) / (before + count);
  place.weight += count;
  measured_left_ += place.cost * left;
  measured_cost_ += place.cost;
  measured_squares_ += place.cost * place.cost;
}

void WorkLeft::cut(std::int64_t samples) {
  measured_left_ = unmeasured_left_ = 0;
  for (Place& place : places_) {
    place.left -= place.pixels * samples;
    if (place.weight > 0) {
      measured_left_ += place.cost * static_cast<double>(place.left);
    } else {
      unmeasured_left_ += static_cast<double>(place.left);
    }
  }
}

double WorkLeft::work_of(double samples) const {
  double work = 0;
  for (const Place& place : places_)
    work +=
        static_cast<double>(place.pixels) * samples * (place.weight > 0 ? place.cost : mean_cost());
  return work;
}

double WorkLeft::cost(std::uint32_t tile) const {
  const Place& place = places_[tile >> shift_];
  return place.weight > 0 ? place.cost : mean_cost();
}

double WorkLeft::spread() const {
  if (measured_places_ < 2 || measured_cost_ <= 0) return 0;
  const double mean = mean_cost();
  return std::sqrt(std::max(0.0, measured_squares_ / measured_places_ / (mean * mean) - 1));
}

double WorkLeft::work() const {
  return std::max(0.0, measured_left_ + unmeasured_left_ * mean_cost());
}

}  // namespace tessera::server
