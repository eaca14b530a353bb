#include "worker/scene/textures.hpp"

#include <gtest/gtest.h>

#include <array>
#include <string>

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

TEST(SceneTextures, PictureOfOneFileIsKeptOnceWhoeverNamesIt) {
  const TemporaryFolder folder;
  const auto file = folder.write("gray.tga", gray_square());
  scene::Scene scene;
  scene.images = {{"gray.tga", scene::FileRange{file, 0, 0}}};
  scene.textures.resize(1);
  const std::size_t one = load_textures(scene).bytes();
  scene.images.push_back({"model.gltf: /images/3", scene::FileRange{file, 0, 0}});
  scene.textures.resize(2);
  scene.textures[1].image = 1;
  EXPECT_EQ(load_textures(scene).bytes(), one);
  EXPECT_EQ(load_textures(scene).size(), 2U);
}

}  // namespace
}  // namespace tessera::worker
