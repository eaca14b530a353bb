#include "common/job/pass_plan.hpp"

#include <algorithm>
#include <cassert>

namespace tessera {

PassPlan::PassPlan(std::int64_t samples, int pass_most) {
  assert(samples >= 1 && pass_most >= 1);
  constexpr std::int64_t geometric_end = 256;
  std::int64_t end = 0;
  while (end < samples) {
    const std::int64_t fourfold = end == 0 ? 1 : 4 * end;
    const bool grows = fourfold <= geometric_end && fourfold - end <= pass_most;
    const std::int64_t by_rule = grows ? fourfold : end + pass_most;
    end = std::min(samples, by_rule);
    ends_.push_back(end);
    if (end == by_rule) ++regular_;
  }
}

SampleRange PassPlan::pass(std::uint32_t index) const {
  assert(index < count());
  const std::int64_t first = index == 0 ? 0 : ends_[index - 1];
  return {first, ends_[index] - first};
}

bool PassPlan::has_aovs(std::uint32_t index, int aov_samples) const {
  return index == 0 || ends_[index] <= aov_samples;
}

}  // namespace tessera
