#pragma once
#include <string>
#include <vector>

#include "common/image/picture.hpp"
#include "tests/farm/farm.hpp"

/// Pictures as they come out where nothing is disturbed, and whether another has the same bits.
namespace tessera::farm_test {

/// 250×131 so that tiles end in remainders, 100 samples so that the plan does.
struct PictureJob {
  int width = 250, height = 131;  ///< pixels
  int samples = 100;
  int tile = 64;
  int seed = 0;
};

/// With as many samples as two workers of this machine, busy as it is, are at for about so long:
/// what is disturbed for seconds must not be done meanwhile, however fast the machine.
PictureJob lasting(Seconds time, PictureJob job);

/// The scene that farm tests render.
std::string scene_path();
/// What `submit` is told of it, behind the scene.
std::vector<std::string> arguments_of(const PictureJob& job);
/// By one worker in tiles of 64, nothing disturbed; rendered once a process for each picture.
const image::ExrImage& undisturbed(const PictureJob& job);
/// Fails the test, saying where, unless the picture has the same bits as the undisturbed one.
void expect_undisturbed(const PictureJob& job, const image::ExrImage& picture);

}  // namespace tessera::farm_test
