#include "common/scene/gltf/animation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "common/base/names.hpp"

namespace tessera::scene::gltf {

namespace {

enum class Interpolation { step, linear, cubic };

/// The keys of a sampler. A value is `width` numbers; of a cubic spline, a key holds the tangent
/// that comes in, the value, and the tangent that goes out.
struct Keys {
  Interpolation interpolation = Interpolation::linear;
  std::vector<float> times, values;
  std::size_t width = 0;

  [[nodiscard]] const float* value(std::size_t key, std::size_t part = 1) const {
    return interpolation == Interpolation::cubic ? &values[(key * 3 + part) * width]
                                                 : &values[key * width];
  }
};

std::vector<double> mixed(const float* a, const float* b, std::size_t width, double t) {
  std::vector<double> out(width);
  for (std::size_t i = 0; i < width; ++i)
    out[i] = (1 - t) * static_cast<double>(a[i]) + t * static_cast<double>(b[i]);
  return out;
}

/// Along the shorter arc, at an even pace.
std::vector<double> slerp(const float* a, const float* b, double t) {
  double cosine = 0;
  for (std::size_t i = 0; i < 4; ++i)
    cosine += static_cast<double>(a[i]) * static_cast<double>(b[i]);
  const double sign = cosine < 0 ? -1 : 1;
  const double angle = std::acos(std::min(std::abs(cosine), 1.0));
  double from = 1 - t, to = t;
  if (angle > 1e-6) {
    from = std::sin((1 - t) * angle) / std::sin(angle);
    to = std::sin(t * angle) / std::sin(angle);
  }
  std::vector<double> out(4);
  for (std::size_t i = 0; i < 4; ++i)
    out[i] = from * static_cast<double>(a[i]) + sign * to * static_cast<double>(b[i]);
  return out;
}

std::vector<double> hermite(const Keys& keys, std::size_t key, double t, double span) {
  const double t2 = t * t, t3 = t2 * t;
  const float *p0 = keys.value(key), *m0 = keys.value(key, 2);
  const float *p1 = keys.value(key + 1), *m1 = keys.value(key + 1, 0);
  std::vector<double> out(keys.width);
  for (std::size_t i = 0; i < keys.width; ++i)
    out[i] = (2 * t3 - 3 * t2 + 1) * static_cast<double>(p0[i]) +
             (t3 - 2 * t2 + t) * span * static_cast<double>(m0[i]) +
             (3 * t2 - 2 * t3) * static_cast<double>(p1[i]) +
             (t3 - t2) * span * static_cast<double>(m1[i]);
  return out;
}

std::vector<double> value_at(const Keys& keys, double time, bool rotation) {
  const auto& times = keys.times;
  const auto after = std::upper_bound(times.begin(), times.end(), time, [](double t, float key) {
    return t < static_cast<double>(key);
  });
  if (after == times.begin()) return mixed(keys.value(0), keys.value(0), keys.width, 0);
  const auto key = static_cast<std::size_t>(after - times.begin()) - 1;
  if (after == times.end() || keys.interpolation == Interpolation::step)
    return mixed(keys.value(key), keys.value(key), keys.width, 0);
  const double begin = static_cast<double>(times[key]);
  const double span = static_cast<double>(times[key + 1]) - begin;
  const double t = (time - begin) / span;
  if (keys.interpolation == Interpolation::cubic) return hermite(keys, key, t, span);
  return rotation ? slerp(keys.value(key), keys.value(key + 1), t)
                  : mixed(keys.value(key), keys.value(key + 1), keys.width, t);
}

class Player {
 public:
  Player(Asset& asset, Accessors& accessors, double time)
      : asset_(asset), accessors_(accessors), time_(time) {}

  void play() {
    for (std::size_t i = 0; i < asset_.model.animations.size(); ++i) {
      const tinygltf::Animation& animation = asset_.model.animations[i];
      for (const tinygltf::AnimationChannel& channel : animation.channels) {
        if (channel.target_node < 0) continue;
        if (!driven_.emplace(channel.target_node, channel.target_path).second) {
          asset_.warn("several animations move the same node; the first is played");
          continue;
        }
        apply(animation, channel, fmt::format("/animations/{}", i));
      }
    }
  }

 private:
  void apply(const tinygltf::Animation& animation, const tinygltf::AnimationChannel& channel,
             const std::string& place) {
    if (static_cast<std::size_t>(channel.sampler) >= animation.samplers.size())
      asset_.fail(place + "/channels", fmt::format("there is no sampler {}", channel.sampler));
    const std::string sampler_place = fmt::format("{}/samplers/{}", place, channel.sampler);
    const auto& sampler = animation.samplers[static_cast<std::size_t>(channel.sampler)];
    tinygltf::Node& node = asset_.model.nodes[static_cast<std::size_t>(channel.target_node)];
    const std::string& path = channel.target_path;
    if (path == "weights") {
      const std::size_t targets = targets_of(node);
      if (targets > 0) node.weights = value_at(read(sampler, targets, sampler_place), time_, false);
      return;
    }
    if (path != "translation" && path != "rotation" && path != "scale") {
      asset_.warn(fmt::format("animations of \"{}\" are not supported", excerpt(path)));
      return;
    }
    if (node.matrix.size() == 16) {
      asset_.warn(
          fmt::format("/nodes/{} has a matrix, and cannot be animated", channel.target_node));
      return;
    }
    const bool rotation = path == "rotation";
    auto& value = rotation ? node.rotation : path == "scale" ? node.scale : node.translation;
    value = value_at(read(sampler, rotation ? 4 : 3, sampler_place), time_, rotation);
  }

  [[nodiscard]] std::size_t targets_of(const tinygltf::Node& node) const {
    if (node.mesh < 0) return 0;
    const auto& primitives = asset_.model.meshes[static_cast<std::size_t>(node.mesh)].primitives;
    return primitives.empty() ? 0 : primitives[0].targets.size();
  }

  Keys read(const tinygltf::AnimationSampler& sampler, std::size_t width,
            const std::string& place) {
    Keys out;
    out.width = width;
    if (sampler.interpolation == "STEP") out.interpolation = Interpolation::step;
    if (sampler.interpolation == "CUBICSPLINE") out.interpolation = Interpolation::cubic;
    out.times = accessors_.scalars(sampler.input, place + "/input");
    if (!std::is_sorted(out.times.begin(), out.times.end(), std::less_equal<>{}))
      asset_.fail(place + "/input", "expected times that grow");
    out.values = accessors_.numbers(sampler.output, place + "/output");
    const std::size_t parts = out.interpolation == Interpolation::cubic ? 3 : 1;
    const std::size_t wanted = out.times.size() * parts * width;
    if (out.values.size() != wanted)
      asset_.fail(place + "/output", fmt::format("expected {} numbers for {} times, found {}",
                                                 wanted, out.times.size(), out.values.size()));
    return out;
  }

  Asset& asset_;
  Accessors& accessors_;
  double time_;
  std::set<std::pair<int, std::string>> driven_;
};

}  // namespace

void animate(Asset& asset, Accessors& accessors, double time) {
  Player(asset, accessors, time).play();
}

double last_key(Asset& asset, Accessors& accessors) {
  double out = 0;
  for (std::size_t i = 0; i < asset.model.animations.size(); ++i)
    for (const tinygltf::AnimationSampler& sampler : asset.model.animations[i].samplers)
      for (const float time :
           accessors.scalars(sampler.input, fmt::format("/animations/{}/samplers", i)))
        out = std::max(out, static_cast<double>(time));
  return out;
}

}  // namespace tessera::scene::gltf
