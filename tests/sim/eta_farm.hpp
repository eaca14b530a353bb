#pragma once
#include <cstdint>
#include <vector>

/// A farm in virtual time whose workers come and go, to see what the time to finish is worth: the
/// real scheduler, a job (and others, at will), workers that render in order.
namespace tessera::sim {

struct EtaModel {
  std::uint64_t seed = 1;
  int workers = 10;    ///< at the beginning
  double spread = 10;  ///< speeds are uniform in [1, spread]
  int columns = 16, rows = 9;
  std::int64_t samples = 512;
  double roughness = 0.5;    ///< σ of the logarithm of a tile's cost
  double job_seconds = 600;  ///< about
  double ramp = 0;           ///< share of the first workers that come during the first half
  double turnover = 0;       ///< how often a worker leaves, and another comes, in a job's time
  int frames = 1;            ///< of about the same cost together
  struct Rival {
    double size = 1;   ///< its work over that of the job that is looked at
    double after = 0;  ///< seconds after which it comes
    int priority = 0;  ///< the job's is 0
  };
  std::vector<Rival> rivals{};
};

/// Any model that a person may have: drawn from the seed.
EtaModel draw_eta_model(std::uint64_t seed);
/// The same with a range of frames, other jobs, or both.
EtaModel draw_shared_eta_model(std::uint64_t seed);

/// What was said at some instant, and what was true.
struct EtaLook {
  double progress = 0;  ///< of the samples
  double expected = 0, low = 0, high = 0, truth = 0;
  [[nodiscard]] bool held() const { return low <= truth && truth <= high; }
};

/// The looks, some two hundred at equal times, from a tenth of the samples onwards.
std::vector<EtaLook> eta_looks(const EtaModel& model);

}  // namespace tessera::sim
