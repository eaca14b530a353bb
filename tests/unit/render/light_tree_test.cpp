#include "worker/render/lights/light_tree.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <numeric>

#include "tests/unit/render/chi2.hpp"

namespace tessera::render {
namespace {

Vec3 within(test::Random& random, float size) {
  const float x = random.next(), y = random.next(), z = random.next();
  return Vec3{x - 0.5F, y - 0.5F, z - 0.5F} * size;
}

/// Of every shape, spread over a cube of 20, their strengths far apart.
std::vector<Light> mixed(int count, std::uint32_t seed) {
  test::Random random(seed);
  std::vector<Light> lights;
  for (int i = 0; i < count; ++i) {
    const Vec3 at = within(random, 20), u = within(random, 1), v = within(random, 1);
    Light light;
    const float strength = random.next();
    light.radiance = gray(strength * strength * strength * 10);
    light.two_sided = i % 11 == 0;
    switch (i % 5) {
      case 0:
        light.shape = TriangleLight{at, at + u, at + v};
        break;
      case 1:
        light.shape = QuadLight{at, u, v};
        break;
      case 2:
        light.shape = SphereLight{at, 0.1F + 0.3F * random.next()};
        break;
      case 3:
        light.shape = PointLight{at};
        break;
      default:
        light.shape =
            SpotLight{.position = at, .axis = normalize(u), .cos_inner = 0.9F, .cos_outer = 0.5F};
    }
    lights.push_back(light);
  }
  return lights;
}

LightContext somewhere(test::Random& random) {
  LightContext context{.p = within(random, 24)};
  if (random.next() < 0.7F) context.n = normalize(within(random, 1));
  return context;
}

std::vector<float> chances(const LightTree& tree, const LightContext& context, std::size_t lights) {
  std::vector<float> out;
  for (std::uint32_t i = 0; i < lights; ++i) out.push_back(tree.pmf(context, i));
  return out;
}

TEST(LightTree, chooses_each_light_as_often_as_its_chance_says) {
  test::Random random(3);
  for (const int count : {25, 60, 1000}) {
    const std::vector<Light> lights = mixed(count, static_cast<std::uint32_t>(count));
    const LightTree tree(lights);
    for (int round = 0; round < 3; ++round) {
      const LightContext context = somewhere(random);
      constexpr int draws = 200'000;
      std::vector<double> observed(lights.size() + 1, 0.0), expected;
      for (const float chance : chances(tree, context, lights.size()))
        expected.push_back(draws * static_cast<double>(chance));
      // The rest: where the way ends at nodes of which neither gives anything.
      expected.push_back(
          std::max(0.0, draws - std::accumulate(expected.begin(), expected.end(), 0.0)));
      for (int i = 0; i < draws; ++i) {
        const LightTree::Pick pick = tree.pick(context, random.bits() * 0x1p-32);
        observed[pick.pmf > 0 ? pick.light : lights.size()] += 1;
        if (pick.pmf > 0) {
          ASSERT_EQ(pick.pmf, tree.pmf(context, pick.light));
        }
      }
      EXPECT_EQ(test::chi2_compare(observed, expected), "") << count << " lights";
    }
  }
}

TEST(LightTree, of_one_light_that_one_is_chosen) {
  const LightTree tree(std::vector<Light>{{.shape = PointLight{{1, 0, 0}}, .radiance = gray(1)}});
  EXPECT_EQ(tree.pick({}, 0.9).light, 0U);
  EXPECT_EQ(tree.pick({}, 0.9).pmf, 1);
  EXPECT_EQ(tree.pmf({}, 0), 1);
}

TEST(LightTree, never_forgets_a_light_that_shines_on_the_point) {
  test::Random random(5);
  for (int round = 0; round < 40; ++round) {
    const std::vector<Light> lights = mixed(50, static_cast<std::uint32_t>(round));
    const LightTree tree(lights);
    for (int place = 0; place < 100; ++place) {
      LightContext context = somewhere(random);
      // Often in the very plane of a light, or beside it.
      const auto* flat = std::get_if<QuadLight>(&lights[random.bits() % 50].shape);
      if (flat != nullptr) {
        context.p = flat->corner + flat->edge_u * (4 * random.next() - 2) +
                    flat->edge_v * (4 * random.next() - 2);
        if (random.next() < 0.5F) context.p += within(random, 1e-3F);
      }
      for (std::uint32_t i = 0; i < lights.size(); ++i) {
        const LightSample drawn = sample(lights[i], context, random.next2());
        if (!drawn || is_black(drawn.radiance)) continue;
        if (!(context.n == Vec3{}) && !(dot(context.n, drawn.wi) > 1e-5F)) continue;
        // Flat ones all but from their plane, where float loses their side.
        const float edge = std::abs(dot(drawn.wi, cone(lights[i]).axis));
        if (!std::holds_alternative<PointLight>(lights[i].shape) && edge < 1e-5F) continue;
        EXPECT_GT(tree.pmf(context, i), 0)
            << "light " << i << " of shape " << lights[i].shape.index();
      }
    }
  }
}

TEST(LightTree, prefers_what_is_near_bright_and_turned_here) {
  const auto square = [](const Vec3& corner, float radiance, bool turned) {
    const Vec3 u{1, 0, 0}, v{0, 1, 0};
    return Light{.shape = turned ? QuadLight{corner, v, u} : QuadLight{corner, u, v},
                 .radiance = gray(radiance)};
  };
  const LightContext floor{.p = {0.5F, 0.5F, 0}, .n = {0, 0, 1}};
  const auto first_chance = [&](const Light& a, const Light& b) {
    const LightTree tree(std::vector<Light>{a, b});
    return tree.pmf(floor, 0);
  };
  EXPECT_EQ(first_chance(square({0, 0, 5}, 1, true), square({0, 0, 6}, 1, false)), 1)
      << "the other is turned away";
  EXPECT_EQ(first_chance(square({0, 0, 5}, 1, true), square({0, 0, -6}, 1, false)), 1)
      << "the other is behind the surface";
  EXPECT_NEAR(first_chance(square({0, 0, 5}, 1, true), square({0, 0, 10}, 1, true)), 0.8, 1e-3);
  EXPECT_NEAR(first_chance(square({0, 0, 5}, 3, true), square({0, 0, 5}, 1, true)), 0.75, 1e-3);
}

TEST(LightTree, is_the_same_for_any_number_of_threads_and_at_any_scale) {
  std::vector<Light> lights = mixed(20'000, 9);
  // Of points alone, as intensity does not grow with the scene's size.
  const LightContext context{.p = {1, 2, 3}, .n = {0, 0, 1}};
  std::vector<float> reference;
  for (const int threads : {1, 2, 5}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 5);
    tbb::task_arena arena(threads);
    arena.execute([&] {
      const std::vector<float> now = chances(LightTree(lights), context, lights.size());
      if (reference.empty()) reference = now;
      EXPECT_EQ(now, reference) << threads;
    });
  }
  for (const float scale : {0x1p-10F, 0x1p10F}) {
    std::vector<Light> points, scaled;
    for (const Light& light : lights) {
      const auto* point = std::get_if<PointLight>(&light.shape);
      if (point == nullptr) continue;
      points.push_back(light);
      scaled.push_back(light);
      scaled.back().shape = PointLight{point->position * scale};
    }
    EXPECT_EQ(chances(LightTree(points), context, points.size()),
              chances(LightTree(scaled), {.p = context.p * scale, .n = context.n}, points.size()));
  }
}

TEST(LightTree, leaves_out_what_gives_nothing_and_takes_any_arrangement) {
  const auto point = [](float x, float strength) {
    return Light{.shape = PointLight{{x, 0, 0}}, .radiance = gray(strength)};
  };
  std::vector<std::vector<Light>> arrangements(4);
  for (int i = 0; i < 300; ++i) {
    const auto x = static_cast<float>(i);
    arrangements[0].push_back(point(1, 1));                               // all in one place
    arrangements[1].push_back(point(x, 1));                               // in a row
    arrangements[2].push_back(point(std::exp2(0.4F * x - 60), 1));        // ever farther apart
    arrangements[3].push_back(point(x, i % 3 == 0 ? 0 : std::exp2(-x)));  // dark, and ever weaker
  }
  for (const std::vector<Light>& lights : arrangements) {
    const LightTree tree(lights);
    for (const LightContext& context :
         {LightContext{.p = {0.5F, 1, 0}}, LightContext{.p = {1, 0, 0}, .n = {0, 0, 1}},
          LightContext{.p = {1e-12F, 0, 0}}, LightContext{.p = {1e12F, 0, 0}}}) {
      double sum = 0;
      for (std::uint32_t i = 0; i < lights.size(); ++i) {
        const float chance = tree.pmf(context, i);
        EXPECT_TRUE(chance >= 0 && chance <= 1);
        if (is_black(lights[i].radiance)) {
          EXPECT_EQ(chance, 0);
        }
        sum += static_cast<double>(chance);
      }
      EXPECT_TRUE(std::abs(sum - 1) < 1e-4 || sum == 0) << sum;
      EXPECT_EQ(sum > 0, tree.pick(context, 0.37).pmf > 0);
    }
  }
  const LightTree none(std::vector<Light>{point(0, 0), {.shape = EnvironmentLight{}}});
  EXPECT_TRUE(none.empty());
  EXPECT_EQ(none.pick({}, 0.5).pmf, 0);
  EXPECT_EQ(none.pmf({}, 0), 0);
}

}  // namespace
}  // namespace tessera::render
