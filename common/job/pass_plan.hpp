#pragma once
#include <cstdint>
#include <vector>

namespace tessera {

/// A range of sample indices, [first, first + count).
struct SampleRange {
  std::int64_t first = 0;
  std::int64_t count = 0;
  bool operator==(const SampleRange&) const = default;
  [[nodiscard]] std::int64_t end() const { return first + count; }
};

/// How a frame's samples are cut into passes. Ends are 1, 4, 16, 64, …, each four times the last,
/// as long as a pass is not larger than the most; from there on every `pass_most` samples; the last
/// end is `samples`. A picture is there at once, and a pass's results stay small. The plan depends
/// on `samples` in its last pass alone, so that samples can be added later.
class PassPlan {
 public:
  PassPlan() = default;
  /// samples ≥ 1; 1 ≤ pass_most.
  PassPlan(std::int64_t samples, int pass_most);

  [[nodiscard]] std::uint32_t count() const { return static_cast<std::uint32_t>(ends_.size()); }
  [[nodiscard]] SampleRange pass(std::uint32_t index) const;
  /// Passes that are the same in every plan of more samples: all, but for a last one that ends
  /// where the samples end and not where the rule would have it end.
  [[nodiscard]] std::uint32_t regular() const { return regular_; }
  [[nodiscard]] std::int64_t samples() const { return ends_.empty() ? 0 : ends_.back(); }
  /// True if AOVs travel with this pass: it ends at or before aov_samples; the first pass always
  /// brings them.
  [[nodiscard]] bool has_aovs(std::uint32_t index, int aov_samples) const;

 private:
  std::vector<std::int64_t> ends_;
  std::uint32_t regular_ = 0;
};

}  // namespace tessera
