#include "common/scene/image_bytes.hpp"

#include <fcntl.h>
#include <fmt/format.h>

#include "common/base/error.hpp"
#include "common/base/file.hpp"
#include "common/base/limits.hpp"

namespace tessera::scene {

namespace {

using Held = std::shared_ptr<const std::vector<std::byte>>;

Place place_of(const Image& image) { return {.file = image.name, .key = {}}; }

std::uint64_t size_in(const File& file, const FileRange& range, const Image& image) {
  const std::uint64_t whole = file.size();
  if (range.offset > whole || range.size > whole - range.offset)
    throw Error(ErrorKind::bad_input, "the picture lies beyond the end of its file",
                place_of(image));
  return range.size == 0 ? whole - range.offset : range.size;
}

/// Calls `use` with the range's file, open. What goes wrong with it is said of the image.
template <typename Use>
auto with_file(const FileRange& range, const Image& image, Use use) {
  try {
    return use(File(range.file, O_RDONLY));
  } catch (const Error& error) {
    throw Error(error.kind(), error.message(), place_of(image));
  }
}

}  // namespace

std::uint64_t encoded_size(const Image& image) {
  const auto* range = std::get_if<FileRange>(&image.encoded);
  if (range == nullptr) return std::get<Held>(image.encoded)->size();
  return with_file(*range, image, [&](const File& file) { return size_in(file, *range, image); });
}

Held encoded_bytes(const Image& image) {
  const auto* range = std::get_if<FileRange>(&image.encoded);
  if (range == nullptr) return std::get<Held>(image.encoded);
  return with_file(*range, image, [&](const File& file) {
    const std::uint64_t size = size_in(file, *range, image);
    if (size > limits::image_file_bytes)
      throw Error(ErrorKind::too_large, fmt::format("{} bytes; a picture's file may have {}", size,
                                                    limits::image_file_bytes));
    auto bytes = std::make_shared<std::vector<std::byte>>(size);
    file.read_at(*bytes, range->offset);
    return Held(std::move(bytes));
  });
}

}  // namespace tessera::scene
