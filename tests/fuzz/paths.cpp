// What may name a file of a scene: a path, or a URI in a glTF file.
#include <filesystem>

#include "common/assets/bundle.hpp"
#include "common/scene/gltf/uri.hpp"
#include "common/scene/scene_file.hpp"
#include "tests/fuzz/target.hpp"

namespace {

using namespace tessera;

void check(const std::string& path) {
  const std::string checked = scene::checked_path(path);
  fuzz::require(scene::checked_path(checked) == checked, "a checked path has one spelling");
  const std::filesystem::path as_file(checked);
  fuzz::require(!checked.empty() && as_file.is_relative(), "a checked path is relative");
  for (const auto& part : as_file) fuzz::require(part != "..", "a checked path leads nowhere else");
  assets::check_path(checked);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(fuzz::text_of(data, size));
  fuzz::take_or_refuse([&] { check(text); });
  fuzz::take_or_refuse([&] { check(scene::gltf::path_of_uri(text)); });
  fuzz::take_or_refuse([&] { (void)scene::gltf::decode_data_uri(text); });
  return 0;
}
