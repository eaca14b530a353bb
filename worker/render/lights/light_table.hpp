#pragma once
#include <cstdint>
#include <vector>

#include "worker/render/lights/light.hpp"

namespace tessera::render {

/// All lights of a scene, at most one of them an environment, and the choice among them: in
/// proportion to their power (Rec.709 luminance), and the environment as often as all others
/// together.
class LightTable {
 public:
  LightTable() = default;
  explicit LightTable(std::vector<Light> lights);

  struct Pick {
    std::uint32_t light = no_id;
    float pmf = 0;  ///< 0: there is no light to choose
  };
  /// Chooses by Walker's alias method, in constant time. `bits` is uniform over 32 bits
  /// (Draw4::bits): a float's 24 do not tell a million lights apart. The number is used up; draw
  /// the point on the light from others.
  [[nodiscard]] Pick pick(std::uint32_t bits) const;
  /// The probability with which pick() gives this light.
  [[nodiscard]] float pmf(std::uint32_t light) const { return pmf_[light]; }

  /// pick() and sample() in one; the sample's pdf holds the choice.
  [[nodiscard]] LightSample sample(const LightContext& context, std::uint32_t pick_bits,
                                   Vec2 u) const;
  /// The density of sample() for a hit on `light`, with the choice.
  [[nodiscard]] float pdf(const LightContext& context, std::uint32_t light,
                          const LightHit& hit) const;

  [[nodiscard]] const std::vector<Light>& lights() const { return lights_; }
  [[nodiscard]] const Light& operator[](std::uint32_t light) const { return lights_[light]; }
  [[nodiscard]] std::uint32_t size() const { return static_cast<std::uint32_t>(lights_.size()); }
  [[nodiscard]] bool empty() const { return lights_.empty(); }
  /// The environment's index, or no_id.
  [[nodiscard]] std::uint32_t environment() const { return environment_; }

 private:
  struct Bucket {
    std::uint32_t threshold = 0xffffffffU;  ///< the own light below it, the alias from there on
    std::uint32_t alias = 0;
  };
  std::vector<Light> lights_;
  std::vector<Bucket> buckets_;
  std::vector<float> pmf_;
  std::uint32_t environment_ = no_id;
};

}  // namespace tessera::render
