#include "client/preflight.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "client/interrupt.hpp"
#include "common/base/error.hpp"
#include "common/base/file.hpp"
#include "common/base/limits.hpp"
#include "common/image/texels.hpp"

namespace tessera::client {

namespace {

void decode(const scene::FileRange& range, const std::string& name) {
  const std::uint64_t size =
      range.size != 0 ? range.size : std::filesystem::file_size(range.file) - range.offset;
  if (size > limits::image_file_bytes)
    throw Error(ErrorKind::too_large,
                fmt::format("{} bytes; {} is the most", size, limits::image_file_bytes),
                {.file = name, .key = {}});
  std::vector<std::byte> bytes(size);
  File(range.file, O_RDONLY).read_at(bytes, range.offset);
  (void)image::decode_texels(bytes, name);
}

}  // namespace

void Preflight::check_pictures(const scene::Scene& scene) {
  std::vector<std::string> problems;
  for (const scene::Image& image : scene.images) {
    throw_if_interrupted();
    try {
      if (const auto* range = std::get_if<scene::FileRange>(&image.encoded)) {
        if (seen_.insert({range->file, range->offset}).second) decode(*range, image.name);
      } else {
        (void)image::decode_texels(
            *std::get<std::shared_ptr<const std::vector<std::byte>>>(image.encoded), image.name);
      }
    } catch (const Error& error) {
      problems.emplace_back(error.what());
    }
  }
  if (problems.empty()) return;
  throw Error(ErrorKind::bad_input,
              problems.size() == 1 ? problems[0]
                                   : fmt::format("{} pictures cannot be shown:\n  {}",
                                                 problems.size(), fmt::join(problems, "\n  ")));
}

}  // namespace tessera::client
