#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "worker/render/lights/alias_table.hpp"
#include "worker/render/lights/light.hpp"
#include "worker/render/lights/light_tree.hpp"

namespace tessera::render {

/// A light sample that is asked for.
struct LightRequest {
  const LightContext* context = nullptr;
  std::uint32_t pick_bits = 0;  ///< uniform over 32 bits
  Vec2 u;
};

/// All lights of a scene, at most one of them an environment, and the choice among them.
///
/// Those that are somewhere are chosen by what they do at the point (LightTree). Those that are
/// infinitely far are chosen by their irradiance, half of the time, and else all alike, so that a
/// sun leaves something to the sky where it is hidden. Each of the two kinds is chosen as often as
/// the other, as nobody knows what is hidden from where; but where what is near can give nothing,
/// always the far.
class LightTable {
 public:
  enum class Choice : std::uint8_t {
    by_importance,
    by_power  ///< of all the same everywhere: what others are compared with
  };

  LightTable() = default;
  explicit LightTable(std::vector<Light> lights, Choice choice = Choice::by_importance);

  struct Pick {
    std::uint32_t light = no_id;
    float pmf = 0;  ///< 0: there is no light to choose
  };
  /// `bits` is uniform over 32 bits (Draw4::bits). The number is used up; draw the point on the
  /// light from others.
  [[nodiscard]] Pick pick(const LightContext& context, std::uint32_t bits) const;
  /// The probability with which pick() gives this light.
  [[nodiscard]] float pmf(const LightContext& context, std::uint32_t light) const;

  /// pick() and sample() in one; the sample's pdf holds the choice.
  [[nodiscard]] LightSample sample(const LightContext& context, std::uint32_t pick_bits,
                                   Vec2 u) const;
  /// The same for many at once, in less time for each, with the same bits: found[i] answers
  /// asked[i].
  void sample(std::span<const LightRequest> asked, std::span<LightSample> found) const;
  /// The density of sample() for a hit on `light`, with the choice.
  [[nodiscard]] float pdf(const LightContext& context, std::uint32_t light,
                          const LightHit& hit) const;

  [[nodiscard]] const std::vector<Light>& lights() const { return lights_; }
  [[nodiscard]] const Light& operator[](std::uint32_t light) const { return lights_[light]; }
  [[nodiscard]] std::uint32_t size() const { return static_cast<std::uint32_t>(lights_.size()); }
  [[nodiscard]] bool empty() const { return lights_.empty(); }
  /// Those that a ray which leaves the scene may run into.
  [[nodiscard]] const std::vector<std::uint32_t>& seen_far() const { return seen_far_; }

 private:
  void weigh_far();
  /// How often a light that is somewhere is chosen.
  [[nodiscard]] double near_share(const LightContext& context) const;

  std::vector<Light> lights_;
  LightTree near_;
  std::vector<std::uint32_t> far_;  ///< which are infinitely far, in order …
  AliasTable far_choice_;           ///< … and the choice among them
  AliasTable by_power_;             ///< of all, where that is how they are chosen
  std::vector<std::uint32_t> seen_far_;
};

}  // namespace tessera::render
