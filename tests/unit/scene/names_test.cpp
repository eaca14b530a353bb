#include "common/scene/names.hpp"

#include <gmock/gmock.h>

#include "worker/render/filter.hpp"
#include "worker/render/integrators/integrator.hpp"
#include "worker/render/sampler.hpp"

/// What a scene or a command line may name is what the renderer's tables have.
namespace tessera {
namespace {

TEST(Names, of_integrators_are_the_renderers) {
  EXPECT_THAT(scene::integrator_names,
              testing::UnorderedElementsAreArray(render::integrator_names()));
}
TEST(Names, of_samplers_are_the_renderers) {
  EXPECT_THAT(scene::sampler_names, testing::UnorderedElementsAreArray(render::sampler_names()));
}
TEST(Names, of_filters_are_the_renderers) {
  EXPECT_THAT(scene::filter_names, testing::UnorderedElementsAreArray(render::filter_names()));
}

}  // namespace
}  // namespace tessera
