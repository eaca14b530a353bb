#include <algorithm>
#include <cassert>
#include <cstring>
#include <string>

#include "common/image/exr_layout.hpp"
#include "common/image/picture.hpp"
#include "common/image/zip.hpp"

namespace tessera::image {

namespace {

/// A channel of the written picture: of the table as it is, or made of it.
struct OutputChannel {
  std::string name;
  enum class Source { plane, variance, samples } source = Source::plane;
  std::size_t plane = 0;
};

std::vector<OutputChannel> output_channels() {
  std::vector<OutputChannel> out;
  for (std::size_t i = 0; i < channel_count; ++i) {
    const Channel& channel = channel_table()[i];
    if (channel.merge == Merge::moment2)
      out.push_back(
          {"variance" + std::string(channel.name.substr(2)), OutputChannel::Source::variance, i});
    else
      out.push_back({std::string(channel.name), OutputChannel::Source::plane, i});
  }
  out.push_back({"samples", OutputChannel::Source::samples, 0});
  std::sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return out;
}

/// Variance of the mean of n samples whose squared deviations sum to m2.
float variance_of_mean(float m2, std::uint32_t n) {
  if (n < 2) return 0;
  const double count = n;
  return static_cast<float>(static_cast<double>(m2) / (count * (count - 1)));
}

void fill_row(const FrameImage& frame, const OutputChannel& channel, std::size_t y,
              std::span<float> row) {
  const std::size_t first = y * row.size();
  const std::span<const std::uint32_t> samples =
      std::span(frame.samples).subspan(first, row.size());
  const std::span<const float> values = frame.plane(channel.plane).subspan(first, row.size());
  switch (channel.source) {
    case OutputChannel::Source::plane:
      std::copy(values.begin(), values.end(), row.begin());
      return;
    case OutputChannel::Source::variance:
      std::transform(values.begin(), values.end(), samples.begin(), row.begin(), variance_of_mean);
      return;
    case OutputChannel::Source::samples:
      std::transform(samples.begin(), samples.end(), row.begin(),
                     [](std::uint32_t n) { return static_cast<float>(n); });
      return;
  }
}

void append(std::vector<std::byte>& out, std::span<const std::byte> bytes) {
  out.insert(out.end(), bytes.begin(), bytes.end());
}

}  // namespace

std::vector<std::byte> encode_exr(const FrameImage& frame, const Metadata& metadata,
                                  Compression compression) {
  assert(frame.values.size() == channel_count * frame.pixels() &&
         frame.samples.size() == frame.pixels());
  const std::vector<OutputChannel> channels = output_channels();
  ExrLayout layout{.data = {0, 0, frame.width, frame.height},
                   .film_width = frame.width,
                   .film_height = frame.height,
                   .channels = {},
                   .compression = compression};
  for (const auto& channel : channels) layout.channels.push_back(channel.name);

  std::vector<std::byte> out = exr_header(layout, metadata.attributes());
  const std::size_t table = out.size();
  std::vector<std::uint64_t> offsets;
  out.reserve(table + layout.chunks() * 16 +
              layout.line_bytes() * static_cast<std::size_t>(frame.height));
  out.resize(table + layout.chunks() * sizeof(std::uint64_t));

  const auto width = static_cast<std::size_t>(frame.width);
  std::vector<float> chunk;
  ZipCompressor zip;
  for (int y = 0; y < frame.height; y += layout.lines_per_chunk()) {
    const int lines = std::min(layout.lines_per_chunk(), frame.height - y);
    chunk.resize(static_cast<std::size_t>(lines) * channels.size() * width);
    auto row = std::span(chunk);
    for (int line = y; line < y + lines; ++line) {
      for (const auto& channel : channels) {
        fill_row(frame, channel, static_cast<std::size_t>(line), row.first(width));
        row = row.subspan(width);
      }
    }
    const std::span<const std::byte> raw = std::as_bytes(std::span(chunk));
    std::span<const std::byte> packed;
    if (compression == Compression::zip) packed = zip.compress(raw);
    if (packed.empty()) packed = raw;
    offsets.push_back(out.size());
    const std::array<std::int32_t, 2> leader{y, static_cast<std::int32_t>(packed.size())};
    append(out, std::as_bytes(std::span(leader)));
    append(out, packed);
  }
  std::memcpy(out.data() + table, offsets.data(), offsets.size() * sizeof(std::uint64_t));
  return out;
}

}  // namespace tessera::image
