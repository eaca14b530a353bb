#include "tests/farm/large_scene.hpp"

#include <array>
#include <fstream>
#include <nlohmann/json.hpp>

namespace tessera::farm_test {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr std::size_t header_bytes = 18;

/// True colour without packing, every picture with other bytes at its end.
void write_tga(const fs::path& file, int side, int number) {
  const auto low = static_cast<char>(side & 0xff), high = static_cast<char>(side >> 8);
  const std::array<char, header_bytes> header{0, 0, 2, 0,   0,    0,   0,    0,  0,
                                              0, 0, 0, low, high, low, high, 24, 0};
  std::ofstream out(file, std::ios::binary);
  out.write(header.data(), header.size());
  const std::array<char, 3> last{static_cast<char>(number & 0xff), static_cast<char>(number >> 8),
                                 1};
  out.seekp(static_cast<std::streamoff>(header_bytes) + std::streamoff{side} * side * 3 - 3);
  out.write(last.data(), last.size());
}

}  // namespace

LargeScene::LargeScene(const fs::path& folder, const LargeSceneSettings& settings)
    : folder_(folder / "large") {
  fs::create_directories(folder_);
  json scene;
  scene["tessera"] = 1;
  scene["film"] = {{"width", 16}, {"height", 16}};
  scene["render"] = {{"samples", 1}};
  scene["camera"] = {{"eye", {0, 0, 5}}, {"target", {0, 0, 0}}, {"fov", 40}};
  for (int i = 0; i < settings.pictures; ++i) {
    const std::string name = "picture" + std::to_string(i);
    write_tga(picture(i), settings.side, i);
    scene["textures"][name] = {{"file", picture(i).filename().string()}};
    scene["materials"][name] = {{"type", "principled"}, {"base_color", {{"texture", name}}}};
    scene["shapes"].push_back({{"type", "sphere"}, {"material", name}});
  }
  scene["environment"]["radiance"] = {1, 1, 1};
  std::ofstream(folder_ / "scene.json") << scene.dump();
  for (const auto& entry : fs::directory_iterator(folder_)) bytes_ += entry.file_size();
}

fs::path LargeScene::picture(int index) const {
  return folder_ / ("picture" + std::to_string(index) + ".tga");
}

}  // namespace tessera::farm_test
