#include <algorithm>
#include <cassert>
#include <string>

#include "common/base/limits.hpp"
#include "common/image/exr_layout.hpp"
#include "common/image/picture.hpp"
#include "common/image/zip.hpp"
#include "common/job/matte.hpp"

namespace tessera::image {

namespace {

/// A channel of the written picture: of the table as it is, or made of it.
struct OutputChannel {
  std::string name;
  enum class Source { plane, variance, samples } source = Source::plane;
  std::size_t plane = 0;
};

/// By channel: true for what Cryptomattes keep and a picture does not show.
std::vector<bool> slots_beyond_the_ranks(const ChannelLayout& layout) {
  std::vector<bool> out(layout.size());
  for (const AovPlanes& aov : layout.aovs())
    if (layout[aov.first].merge == Merge::matte)
      for (std::size_t i = 2 * matte_ranks; i < 2 * matte_slots; ++i) out[aov.first + i] = true;
  return out;
}

std::vector<OutputChannel> output_channels(const ChannelLayout& layout) {
  std::vector<OutputChannel> out;
  const std::vector<bool> left_out = slots_beyond_the_ranks(layout);
  for (std::size_t i = 0; i < layout.size(); ++i) {
    if (left_out[i]) continue;
    const Channel& channel = layout[i];
    if (channel.merge == Merge::moment2)
      out.push_back({"variance" + channel.name.substr(2), OutputChannel::Source::variance, i});
    else
      out.push_back({channel.name, OutputChannel::Source::plane, i});
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

/// Rows of a FrameImage.
class RowsInMemory : public FrameRows {
 public:
  explicit RowsInMemory(const FrameImage& frame) : frame_(frame) {
    assert(frame.values.size() == frame.layout->size() * frame.pixels() &&
           frame.samples.size() == frame.pixels());
  }
  [[nodiscard]] int film_width() const override { return frame_.width; }
  [[nodiscard]] int film_height() const override { return frame_.height; }
  [[nodiscard]] Rect window() const override { return {0, 0, frame_.width, frame_.height}; }
  [[nodiscard]] const ChannelLayout& layout() const override { return *frame_.layout; }
  void values(std::size_t channel, int y, std::span<float> row) const override {
    copy(frame_.plane(channel), y, row);
  }
  void samples(int y, std::span<std::uint32_t> row) const override {
    copy<std::uint32_t>(frame_.samples, y, row);
  }

 private:
  template <class Value>
  static void copy(std::span<const Value> plane, int y, std::span<Value> row) {
    const auto from = plane.subspan(static_cast<std::size_t>(y) * row.size(), row.size());
    std::copy(from.begin(), from.end(), row.begin());
  }
  const FrameImage& frame_;
};

class BytesInMemory : public ByteSink {
 public:
  /// Memory that is reserved and not used costs nothing; growing costs copies.
  explicit BytesInMemory(std::size_t most) { bytes_.reserve(most); }
  void append(std::span<const std::byte> bytes) override {
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  void replace(std::size_t offset, std::span<const std::byte> bytes) override {
    assert(offset + bytes.size() <= bytes_.size());
    std::copy(bytes.begin(), bytes.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(offset));
  }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

/// The file's rows, channel after channel in each, as they stand in a chunk.
class RowWriter {
 public:
  RowWriter(const FrameRows& frame, const std::vector<OutputChannel>& channels)
      : frame_(frame), channels_(channels), samples_(static_cast<std::size_t>(frame.width())) {}

  /// Rows [first, last); valid until the next call.
  std::span<const std::byte> rows(int first, int last) {
    const std::size_t width = samples_.size();
    chunk_.resize(static_cast<std::size_t>(last - first) * channels_.size() * width);
    auto rest = std::span(chunk_);
    for (int y = first; y < last; ++y) {
      frame_.samples(y, samples_);
      for (const OutputChannel& channel : channels_) {
        fill(channel, y, rest.first(width));
        rest = rest.subspan(width);
      }
    }
    return std::as_bytes(std::span(chunk_));
  }

 private:
  void fill(const OutputChannel& channel, int y, std::span<float> row) const {
    if (channel.source == OutputChannel::Source::samples) {
      std::transform(samples_.begin(), samples_.end(), row.begin(),
                     [](std::uint32_t n) { return static_cast<float>(n); });
      return;
    }
    frame_.values(channel.plane, y, row);
    if (channel.source == OutputChannel::Source::variance)
      std::transform(row.begin(), row.end(), samples_.begin(), row.begin(), variance_of_mean);
  }

  const FrameRows& frame_;
  const std::vector<OutputChannel>& channels_;
  std::vector<std::uint32_t> samples_;  ///< of the present row
  std::vector<float> chunk_;
};

}  // namespace

void write_exr(const FrameRows& frame, const Metadata& metadata, ByteSink& sink,
               Compression compression) {
  const std::vector<OutputChannel> channels = output_channels(frame.layout());
  ExrLayout layout{.data = frame.window(),
                   .film_width = frame.film_width(),
                   .film_height = frame.film_height(),
                   .pixel_aspect = metadata.pixel_aspect(),
                   .channels = {},
                   .compression = compression};
  for (const auto& channel : channels) layout.channels.push_back(channel.name);

  const std::vector<std::byte> header = exr_header(layout, metadata.attributes());
  std::vector<std::uint64_t> offsets(layout.chunks());
  const auto table = std::as_bytes(std::span(offsets));
  sink.append(header);
  sink.append(table);  // where chunks begin is known when they are written
  std::uint64_t end = header.size() + table.size();
  RowWriter writer(frame, channels);
  ZipCompressor zip;
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    const int y = static_cast<int>(i) * layout.lines_per_chunk();
    const std::span<const std::byte> raw =
        writer.rows(y, std::min(y + layout.lines_per_chunk(), frame.height()));
    std::span<const std::byte> packed;
    if (compression == Compression::zip) packed = zip.compress(raw);
    if (packed.empty()) packed = raw;
    const std::array<std::int32_t, 2> leader{layout.data.y + y,
                                             static_cast<std::int32_t>(packed.size())};
    sink.append(std::as_bytes(std::span(leader)));
    sink.append(packed);
    offsets[i] = end;
    end += sizeof leader + packed.size();
  }
  sink.replace(header.size(), table);
}

std::vector<std::byte> encode_exr(const FrameRows& frame, const Metadata& metadata,
                                  Compression compression) {
  constexpr std::size_t header_and_table = 64 * limits::KiB;
  BytesInMemory sink((frame.layout().size() + 1) * sizeof(float) *
                         static_cast<std::size_t>(frame.width()) *
                         static_cast<std::size_t>(frame.height()) +
                     header_and_table);
  write_exr(frame, metadata, sink, compression);
  return sink.take();
}

std::vector<std::byte> encode_exr(const FrameImage& frame, const Metadata& metadata,
                                  Compression compression) {
  return encode_exr(RowsInMemory(frame), metadata, compression);
}

}  // namespace tessera::image
