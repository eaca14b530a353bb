// What the time to finish is worth for real jobs: several, rendered by two workers of this machine,
// looked at from a tenth of each on. How often the truth lay in the interval.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "tests/farm/farm.hpp"

namespace tessera::farm_test {
namespace {

using Clock = std::chrono::steady_clock;

struct RealJob {
  std::string scene;
  int side = 512, samples = 64;
};

struct Look {
  double at = 0, low = 0, expected = 0, high = 0;
};

/// Of one job; `ended` on the same clock as the looks.
struct Report {
  int looks = 0, held = 0, sooner = 0, later = 0;
  double error = 0, width = 0;
  void add(const std::vector<Look>& all, double ended) {
    for (const Look& look : all) {
      const double truth = ended - look.at;
      ++looks;
      held += look.low <= truth && truth <= look.high ? 1 : 0;
      sooner += truth < look.low ? 1 : 0;
      later += truth > look.high ? 1 : 0;
      error += std::abs(look.expected - truth) / std::max(truth, 0.1);
      width += (look.high - look.low) / std::max(look.expected, 0.1);
    }
  }
  void print(const std::string& name) const {
    if (looks == 0) return;
    const double part = 100.0 / looks;
    std::printf(
        "%-34s %5d looks  held %5.1f %%  sooner %5.1f %%  later %5.1f %%  width %4.0f %%  "
        "error %4.0f %%\n",
        name.c_str(), looks, part * held, part * sooner, part * later, part * width, part * error);
    std::fflush(stdout);
  }
};

/// Looks at these jobs, which are rendered at once, until all are done.
Report watch(Farm& farm, const std::vector<RealJob>& jobs) {
  std::map<std::string, std::vector<Look>> open;
  for (const RealJob& job : jobs) {
    const std::string size = std::to_string(job.side) + "x" + std::to_string(job.side);
    const std::string scene = (sources() / "scenes" / job.scene).string();
    open[farm.submit(scene, {"--size", size, "--samples", std::to_string(job.samples)})];
  }
  Report report;
  const auto began = Clock::now();
  const auto now = [&] { return std::chrono::duration<double>(Clock::now() - began).count(); };
  while (!open.empty()) {
    if (now() > 1800) throw std::runtime_error("jobs did not finish\n" + farm.logs());
    for (auto entry = open.begin(); entry != open.end();) {
      const nlohmann::json job = farm.job(entry->first);
      if (job.at("state") == "done") {
        report.add(entry->second, now());
        entry = open.erase(entry);
        continue;
      }
      if (job.at("progress").get<double>() >= 0.1 && job.at("eta_seconds").is_number())
        entry->second.push_back({now(), job.at("eta_low_seconds").get<double>(),
                                 job.at("eta_seconds").get<double>(),
                                 job.at("eta_high_seconds").get<double>()});
      ++entry;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return report;
}

}  // namespace
}  // namespace tessera::farm_test

/// bench_eta [--quick]
int main(int count, char** arguments) {
  using namespace tessera::farm_test;
  const bool quick = count > 1 && std::strcmp(arguments[1], "--quick") == 0;
  const int more = quick ? 1 : 4;
  Farm farm;
  farm.add_worker();
  farm.add_worker();
  for (const char* const scene : {"cornell.json", "cornell-glass.json"}) {
    for (const int side : {256, 512}) {
      const RealJob job{scene, side, 64 * more * 512 / side};
      const Report alone = watch(farm, {job});
      alone.print(std::string(scene) + " " + std::to_string(side) + "² alone");
      RealJob half = job;
      half.samples /= 2;
      watch(farm, {job, half, half})
          .print(std::string(scene) + " " + std::to_string(side) + "² and two half as large");
    }
  }
  return 0;
}
