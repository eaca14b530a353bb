#include "client/preflight.hpp"

#include "client/interrupt.hpp"
#include "common/base/error.hpp"
#include "common/scene/image_bytes.hpp"

namespace tessera::client {

void Preflight::check(const scene::LoadedScene& loaded) {
  std::vector<Error> problems = loaded.problems;
  for (const scene::Image& image : loaded.scene.images) {
    throw_if_interrupted();
    try {
      const auto* range = std::get_if<scene::FileRange>(&image.encoded);
      if (range != nullptr && !seen_.insert({range->file, range->offset}).second) continue;
      const auto bytes = scene::encoded_bytes(image);
      decoded_bytes_ += image::decode_texels(*bytes, image.name, &budget_).bytes.size();
    } catch (const Error& error) {
      problems.push_back(error);
    }
  }
  if (!problems.empty()) throw scene::as_one(problems);
}

}  // namespace tessera::client
