#include "client/preflight.hpp"

#include <fcntl.h>
#include <fmt/format.h>

#include "client/interrupt.hpp"
#include "common/base/error.hpp"
#include "common/base/file.hpp"

namespace tessera::client {

namespace {

/// How many bytes its texels have.
std::uint64_t decode(const scene::FileRange& range, const std::string& name,
                     image::TexelBudget& budget) {
  const std::uint64_t size =
      range.size != 0 ? range.size : std::filesystem::file_size(range.file) - range.offset;
  if (size > limits::image_file_bytes)
    throw Error(ErrorKind::too_large,
                fmt::format("{} bytes; {} is the most", size, limits::image_file_bytes),
                {.file = name, .key = {}});
  std::vector<std::byte> bytes(size);
  File(range.file, O_RDONLY).read_at(bytes, range.offset);
  return image::decode_texels(bytes, name, &budget).bytes.size();
}

}  // namespace

void Preflight::check(const scene::LoadedScene& loaded) {
  std::vector<Error> problems = loaded.problems;
  for (const scene::Image& image : loaded.scene.images) {
    throw_if_interrupted();
    try {
      if (const auto* range = std::get_if<scene::FileRange>(&image.encoded)) {
        if (seen_.insert({range->file, range->offset}).second)
          decoded_bytes_ += decode(*range, image.name, budget_);
      } else {
        const auto& held = *std::get<std::shared_ptr<const std::vector<std::byte>>>(image.encoded);
        decoded_bytes_ += image::decode_texels(held, image.name, &budget_).bytes.size();
      }
    } catch (const Error& error) {
      problems.push_back(error);
    }
  }
  if (!problems.empty()) throw scene::as_one(problems);
}

}  // namespace tessera::client
