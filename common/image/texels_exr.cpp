#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <fmt/format.h>
#include <half.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

#include "common/base/error.hpp"
#include "common/image/exr_layout.hpp"
#include "common/image/exr_stream.hpp"
#include "common/image/texels_decode.hpp"

namespace tessera::image {

namespace {

/// R, G, B and A where it is there, or Y alone.
std::vector<std::string> channels_of(const Imf::ChannelList& list, const std::string& name) {
  const auto has = [&](const char* channel) { return list.findChannel(channel) != nullptr; };
  if (has("R") && has("G") && has("B")) {
    if (has("A")) return {"R", "G", "B", "A"};
    return {"R", "G", "B"};
  }
  if (has("Y") && !has("RY")) return {"Y"};
  std::string there;
  for (auto it = list.begin(); it != list.end() && there.size() < 200; ++it)
    there += (there.empty() ? "" : ", ") + printable(it.name());
  refuse_picture(name, fmt::format("expected the channels R, G and B, or Y; found {}", there));
}

template <class Value, class Tame>
void tame_all(Texels& picture, Tame tame) {
  for (std::size_t at = 0; at < picture.bytes.size(); at += sizeof(Value)) {
    Value value;
    std::memcpy(&value, picture.bytes.data() + at, sizeof value);
    value = tame(value);
    std::memcpy(picture.bytes.data() + at, &value, sizeof value);
  }
}

Texels decode_checked(std::span<const std::byte> file, const PictureSource& source) {
  const std::string& name = source.name;
  MemoryStream stream(file, name);
  Imf::InputFile input(stream);
  const Imf::Header& header = input.header();
  const std::vector<std::string> channels = channels_of(header.channels(), name);
  const bool halves = std::all_of(channels.begin(), channels.end(), [&](const std::string& one) {
    return header.channels()[one].type == Imf::HALF;
  });
  const Imath::Box2i window = header.dataWindow();
  Texels out = picture_of(
      std::int64_t{window.max.x} - window.min.x + 1, std::int64_t{window.max.y} - window.min.y + 1,
      static_cast<int>(channels.size()), halves ? TexelFormat::f16 : TexelFormat::f32, source);
  const std::size_t size = bytes_of(out.format);
  Imf::FrameBuffer buffer;
  for (std::size_t i = 0; i < channels.size(); ++i)
    buffer.insert(channels[i],
                  Imf::Slice::Make(halves ? Imf::HALF : Imf::FLOAT, out.bytes.data() + i * size,
                                   window, size * channels.size(), out.row_bytes()));
  input.setFrameBuffer(buffer);
  input.readPixels(window.min.y, window.max.y);
  if (halves)
    tame_all<half>(out, [](half v) { return half(tamed(v, half_most)); });
  else
    tame_all<float>(out, [](float v) { return tamed(v, float_most); });
  return out;
}

}  // namespace

Texels decode_exr(std::span<const std::byte> file, const PictureSource& source) {
  const std::string& name = source.name;
  check_exr_bounds(file, name);
  try {
    return decode_checked(file, source);
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& problem) {
    refuse_picture(name, fmt::format("not a valid EXR file: {}", printable(problem.what())));
  }
}

}  // namespace tessera::image
