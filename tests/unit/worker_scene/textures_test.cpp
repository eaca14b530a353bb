#include "worker/scene/textures.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "common/base/error.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tessera::worker {
namespace {

/// A TGA file of 2 by 2 gray texels.
std::string gray_square() {
  std::string out(18, '\0');
  out[2] = 3;
  out[12] = out[14] = 2;
  out[16] = 8;
  return out + "abcd";
}

scene::Scene scene_with(const std::filesystem::path& picture) {
  scene::Scene scene;
  scene.images = {{"gray.tga", scene::FileRange{picture, 0, 0}}};
  scene.textures.resize(1);
  return scene;
}

constexpr std::uint64_t gray_bytes = 4;  // decoded

TEST(SceneTextures, PictureOfOneFileIsKeptOnceWhoeverNamesIt) {
  const TemporaryFolder folder;
  const auto file = folder.write("gray.tga", gray_square());
  scene::Scene scene = scene_with(file);
  image::TexelBudget enough(2 * gray_bytes);
  const std::size_t one = load_textures(scene, enough).bytes();
  scene.images.push_back({"model.gltf: /images/3", scene::FileRange{file, 0, 0}});
  scene.textures.resize(2);
  scene.textures[1].image = 1;
  const render::TextureTable both = load_textures(scene, enough);
  EXPECT_EQ(both.bytes(), one);
  EXPECT_EQ(both.size(), 2U);
}

TEST(SceneTextures, TheEnvironmentSharesTheBudgetOfTheTextures) {
  const TemporaryFolder folder;
  scene::Scene scene = scene_with(folder.write("gray.tga", gray_square()));
  scene.environment.emplace().image = 0;
  image::TexelBudget both(2 * gray_bytes), one(2 * gray_bytes - 1);
  EXPECT_NO_THROW(load_textures(scene, both));
  EXPECT_NO_THROW(load_environment(scene, both));
  EXPECT_NO_THROW(load_textures(scene, one));
  try {
    load_environment(scene, one);
    FAIL() << "took more than there is";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::too_large);
    EXPECT_EQ(error.place().file, "gray.tga");
  }
}

}  // namespace
}  // namespace tessera::worker
