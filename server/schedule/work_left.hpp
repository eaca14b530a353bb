#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/job/job_spec.hpp"

namespace tessera::server {

/// What is left of a job, in units of work: samples, weighted by what those of their tile cost
/// beside others, as far as that has been measured. A call costs O(1); tiles that stand next to
/// each other share their place where there are more than `places_most`.
class WorkLeft {
 public:
  static constexpr std::uint32_t places_most = 1U << 16;
  explicit WorkLeft(const JobPlan& plan);

  /// So many samples of the tile are closed; they are left no more. All counts are of pixels ×
  /// samples.
  void closed(std::uint32_t tile, std::int64_t samples);
  /// Samples of the tile took so much work: their seconds times their worker's power.
  void measured(std::uint32_t tile, std::int64_t samples, double work);

  /// So many samples of every pixel of a frame are not rendered after all. O(places).
  void cut(std::int64_t samples);
  /// Of so many samples of every pixel of a frame. O(places).
  [[nodiscard]] double work_of(double samples) const;

  /// What a sample of the tile costs; 1 on average at first, the mean of what was measured where
  /// the tile was not.
  [[nodiscard]] double cost(std::uint32_t tile) const;
  [[nodiscard]] double mean_cost() const {
    return measured_places_ > 0 ? measured_cost_ / measured_places_ : 1;
  }
  /// The standard deviation of tiles' costs, over their mean.
  [[nodiscard]] double spread() const;
  /// Of all that is not closed.
  [[nodiscard]] double work() const;

 private:
  struct Place {
    double cost = 0;
    double weight = 0;  // samples behind `cost`; 0: not measured
    std::int64_t left = 0;
    std::int64_t pixels = 0;
  };
  std::uint32_t shift_ = 0;
  std::vector<Place> places_;
  double measured_left_ = 0;    // Σ cost · left of the measured
  double unmeasured_left_ = 0;  // samples
  double measured_cost_ = 0, measured_squares_ = 0,
         measured_places_ = 0;  // the sums of their costs and of the squares, and how many
};

}  // namespace tessera::server
