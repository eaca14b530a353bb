#include <ImfChannelList.h>
#include <ImfDoubleAttribute.h>
#include <ImfFloatAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfIntAttribute.h>
#include <ImfMatrixAttribute.h>
#include <ImfStringAttribute.h>
#include <fmt/format.h>

#include <algorithm>

#include "common/base/error.hpp"
#include "common/base/files.hpp"
#include "common/base/limits.hpp"
#include "common/base/names.hpp"
#include "common/image/exr_core.hpp"
#include "common/image/exr_header_check.hpp"
#include "common/image/exr_layout.hpp"
#include "common/image/exr_stream.hpp"
#include "common/image/picture.hpp"

namespace tessera::image {

namespace {

constexpr std::int64_t values_max = limits::film_pixels_max * 32;
constexpr int channels_max = 1024;
/// No compression of OpenEXR's gets below this share (deflate, the densest, reaches 1032): a small
/// file that says it is large is refused before memory is taken for it.
constexpr std::int64_t densest_compression = 2048;

}  // namespace

void check_exr_bounds(std::span<const std::byte> exr, const std::string& name) {
  check_exr_header(exr, name);
  const ExrCore file(exr, name);
  const auto refuse = [&](const std::string& message) {
    throw Error(ErrorKind::bad_input, message, {.file = name});
  };
  int parts = 0;
  file.require(exr_get_count(file.get(), &parts));
  if (parts < 1) refuse("not a valid EXR file: it has no header that can be read");
  for (int part = 0; part < parts; ++part) {
    exr_storage_t storage{};
    file.require(exr_get_storage(file.get(), part, &storage));
    if (part == 0 && storage != EXR_STORAGE_SCANLINE && storage != EXR_STORAGE_TILED)
      refuse("expected a flat picture, found deep data");
    exr_attr_box2i_t window{};
    file.require(exr_get_data_window(file.get(), part, &window));
    const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
    const std::int64_t height = std::int64_t{window.max.y} - window.min.y + 1;
    const exr_attr_chlist_t* channels = nullptr;
    file.require(exr_get_channels(file.get(), part, &channels));
    const int count = channels->num_channels;
    const auto file_bytes = static_cast<std::int64_t>(exr.size());
    if (width < 1 || height < 1 || width > limits::film_side_max ||
        height > limits::film_side_max || count < 1 || count > channels_max ||
        width * height > values_max / count ||
        width * height * count > file_bytes * densest_compression)
      refuse(
          fmt::format("a picture of {} by {} with {} channels is beyond the limits, or more than "
                      "the file can hold",
                      width, height, count));
    for (int i = 0; i < count; ++i)
      if (channels->entries[i].x_sampling != 1 || channels->entries[i].y_sampling != 1)
        refuse(fmt::format("channel {} is subsampled, which is not supported",
                           printable(channels->entries[i].name.str)));
  }
}

namespace {

Metadata metadata_in(const Imf::Header& header) {
  Metadata metadata;
  metadata.set_pixel_aspect(header.pixelAspectRatio());
  for (auto it = header.begin(); it != header.end(); ++it) {
    const std::string_view name = it.name();
    const Imf::Attribute& attribute = it.attribute();
    if (is_layout_attribute(name) || name.size() > 31) continue;
    if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&attribute))
      metadata.set(name, text->value());
    if (const auto* whole = dynamic_cast<const Imf::IntAttribute*>(&attribute))
      metadata.set(name, static_cast<std::int32_t>(whole->value()));
    if (const auto* real = dynamic_cast<const Imf::FloatAttribute*>(&attribute))
      metadata.set(name, real->value());
    if (const auto* real = dynamic_cast<const Imf::DoubleAttribute*>(&attribute))
      metadata.set(name, real->value());
    if (const auto* matrix = dynamic_cast<const Imf::M44fAttribute*>(&attribute)) {
      Matrix values{};
      std::copy_n(&matrix->value().x[0][0], values.size(), values.begin());
      metadata.set(name, values);
    }
  }
  return metadata;
}

ExrImage read_checked(std::span<const std::byte> exr, const std::string& name) {
  MemoryStream stream(exr, name);
  Imf::InputFile file(stream);
  const Imf::Header& header = file.header();
  const Imath::Box2i window = header.dataWindow();
  ExrImage image;
  image.width = window.max.x - window.min.x + 1;
  image.height = window.max.y - window.min.y + 1;
  image.metadata = metadata_in(header);
  for (auto it = header.channels().begin(); it != header.channels().end(); ++it)
    image.channels.emplace_back(it.name());
  const std::size_t pixels =
      static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  image.values.resize(image.channels.size() * pixels);

  Imf::FrameBuffer buffer;
  for (std::size_t i = 0; i < image.channels.size(); ++i)
    buffer.insert(
        image.channels[i],
        Imf::Slice::Make(Imf::FLOAT, image.values.data() + i * pixels, window, sizeof(float),
                         sizeof(float) * static_cast<std::size_t>(image.width)));
  file.setFrameBuffer(buffer);
  file.readPixels(window.min.y, window.max.y);
  return image;
}

}  // namespace

bool ExrImage::has(std::string_view channel) const {
  return std::find(channels.begin(), channels.end(), channel) != channels.end();
}

std::span<const float> ExrImage::plane(std::string_view channel) const {
  const auto found = std::find(channels.begin(), channels.end(), channel);
  if (found == channels.end())
    throw Error(ErrorKind::not_found,
                unknown_name("channel", channel,
                             std::vector<std::string_view>(channels.begin(), channels.end())));
  const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  return std::span(values).subspan(static_cast<std::size_t>(found - channels.begin()) * pixels,
                                   pixels);
}

ExrImage read_exr(std::span<const std::byte> exr, const std::string& name) {
  check_exr_bounds(exr, name);
  try {
    return read_checked(exr, name);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& problem) {
    throw Error(ErrorKind::bad_input,
                fmt::format("not a valid EXR file: {}", printable(problem.what())), {.file = name});
  }
}

Metadata read_exr_header(const std::filesystem::path& file) {
  try {
    return metadata_in(Imf::InputFile(file.c_str()).header());
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& problem) {
    throw Error(ErrorKind::bad_input,
                fmt::format("not a valid EXR file: {}", printable(problem.what())),
                {.file = file.string()});
  }
}

ExrImage read_exr_file(const std::filesystem::path& file) {
  return read_exr(read_file(file, 64 * limits::GiB), file.string());
}

}  // namespace tessera::image
