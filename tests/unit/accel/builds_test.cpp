#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <vector>

#include "worker/accel/accel.hpp"
#include "worker/accel/buffer.hpp"

namespace tessera::accel {
namespace {

/// A small generator of our own: the same numbers everywhere.
struct Numbers {
  std::uint64_t state;
  float next() {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<float>(state >> 40) * 0x1p-24F;
  }
};

std::uint64_t mix(std::uint64_t hash, std::uint32_t value) {
  return (hash ^ value) * 0x100000001b3ULL;
}

/// Builds a soup of 60,000 triangles on `threads` threads and hashes every bit of 20,000 hits.
std::uint64_t hash_of_hits(int threads) {
  const Device device;
  constexpr std::uint32_t count = 60000;
  Numbers numbers{12345};
  Buffer<Point> points(count * 3);
  Buffer<Triangle> triangles(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const Point center{numbers.next(), numbers.next(), numbers.next()};
    for (std::uint32_t k = 0; k < 3; ++k) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        points[3 * i + k][axis] = center[axis] + (numbers.next() - 0.5F) * 0.03F;
      }
    }
    triangles[i] = {3 * i, 3 * i + 1, 3 * i + 2};
  }
  Scene scene(device);
  const std::array<std::span<const Point>, 1> keys{points.span()};
  scene.add_triangles(keys, triangles.span());
  tbb::task_arena arena(threads);
  arena.execute([&] { scene.build(); });

  std::uint64_t hash = 0xcbf29ce484222325ULL;
  std::uint32_t met = 0;
  for (int i = 0; i < 20000; ++i) {
    Ray ray;
    for (float& x : ray.origin) x = numbers.next();
    for (float& x : ray.direction) x = numbers.next() - 0.5F;
    ray.far = std::numeric_limits<float>::infinity();
    const Hit hit = scene.intersect(ray);
    met += hit.any() ? 1 : 0;
    hash = mix(hash, hit.primitive);
    hash = mix(hash, std::bit_cast<std::uint32_t>(hit.t));
    hash = mix(hash, std::bit_cast<std::uint32_t>(hit.u));
    hash = mix(hash, std::bit_cast<std::uint32_t>(hit.v));
    for (const float x : hit.ng) hash = mix(hash, std::bit_cast<std::uint32_t>(x));
  }
  EXPECT_GT(met, 10000U);
  return hash;
}

TEST(Builds, OnOneTwoAndFourThreadsGiveTheSameBits) {
  const tbb::global_control four(tbb::global_control::max_allowed_parallelism, 4);
  const std::uint64_t one = hash_of_hits(1);
  EXPECT_EQ(hash_of_hits(2), one);
  EXPECT_EQ(hash_of_hits(4), one);
}

}  // namespace
}  // namespace tessera::accel
