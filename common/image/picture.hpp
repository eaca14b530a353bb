#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/image/channels.hpp"
#include "common/image/metadata.hpp"

/// Whole frames: as EXR and PNG bytes, and EXR files read back.
namespace tessera::image {

/// A frame's values in memory. Planes stand one after another in the order of the layout, all
/// channels, each row by row from the upper left: means (R, G, B, A premultiplied), M2, nearest.
struct FrameImage {
  int width = 0;
  int height = 0;
  std::vector<float> values;
  std::vector<std::uint32_t>
      samples;  ///< behind each pixel's beauty group; 0 where nothing has arrived
  Layout layout = default_layout();

  [[nodiscard]] std::size_t pixels() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
  [[nodiscard]] std::span<float> plane(std::size_t channel) {
    return std::span(values).subspan(channel * pixels(), pixels());
  }
  [[nodiscard]] std::span<const float> plane(std::size_t channel) const {
    return std::span(values).subspan(channel * pixels(), pixels());
  }
};

/// A frame's values wherever they are, row by row from the upper one.
class FrameRows {
 public:
  virtual ~FrameRows() = default;
  [[nodiscard]] virtual int film_width() const = 0;
  [[nodiscard]] virtual int film_height() const = 0;
  /// The pixels of the film that there are; y and rows below count from its upper left.
  [[nodiscard]] virtual Rect window() const = 0;
  [[nodiscard]] int width() const { return window().width; }
  [[nodiscard]] int height() const { return window().height; }
  [[nodiscard]] virtual const ChannelLayout& layout() const = 0;
  /// Of one channel of the layout, as in FrameImage. `row` has the window's width.
  virtual void values(std::size_t channel, int y, std::span<float> row) const = 0;
  virtual void samples(int y, std::span<std::uint32_t> row) const = 0;
};

/// Takes a file's bytes. Its calls may throw, and then nothing more comes.
class ByteSink {
 public:
  virtual ~ByteSink() = default;
  virtual void append(std::span<const std::byte> bytes) = 0;
  /// Once more bytes that were appended, from `offset` on.
  virtual void replace(std::size_t offset, std::span<const std::byte> bytes) = 0;
};

enum class Compression {
  none,
  zip,  ///< lossless, 16 lines at a time
};

/// An EXR file of one part, scan lines of 32-bit float, Rec. 709 primaries: R, G, B, A
/// (premultiplied), variance.R/G/B (of the pixel's mean: M2/(n(n−1)), 0 for n < 2), the layout's
/// AOVs, samples (n of the pixel). The display window is the film, the data window what was
/// rendered of it. Equal content and metadata give equal bytes. Neither the
/// frame nor the file is in memory as a whole: 16 rows are.
void write_exr(const FrameRows& frame, const Metadata& metadata, ByteSink& sink,
               Compression compression = Compression::zip);
/// The same file in memory.
std::vector<std::byte> encode_exr(const FrameRows& frame, const Metadata& metadata,
                                  Compression compression = Compression::zip);
std::vector<std::byte> encode_exr(const FrameImage& frame, const Metadata& metadata,
                                  Compression compression = Compression::zip);

/// An EXR file as it was read: any flat file of OpenEXR's (the first part of several), every value
/// as float.
struct ExrImage {
  int width = 0;  ///< of the data window
  int height = 0;
  std::vector<std::string> channels;  ///< in the file's order, which is by name
  std::vector<float> values;          ///< planes in the order of `channels`
  Metadata metadata;                  ///< texts, numbers and matrices of the header

  [[nodiscard]] bool has(std::string_view channel) const;
  /// Row by row from the upper left. Throws Error{not_found} that names the nearest channel.
  [[nodiscard]] std::span<const float> plane(std::string_view channel) const;
};

/// Throws Error{bad_input} for what is no EXR file or has no picture within limits.hpp; `name` is
/// what the errors call it.
ExrImage read_exr(std::span<const std::byte> exr, const std::string& name = "EXR");
ExrImage read_exr_file(const std::filesystem::path& file);
/// The texts, numbers and matrices of a file's header alone. Throws Error{bad_input}.
Metadata read_exr_header(const std::filesystem::path& file);

/// An 8-bit RGB PNG file in sRGB: each colour times 2^exposure_stops, clipped to [0, 1]. `rgb` is
/// three planes (or more; what follows is not read), premultiplied, so that what is transparent is
/// shown over black.
std::vector<std::byte> encode_png(int width, int height, std::span<const float> rgb,
                                  double exposure_stops = 0);

/// The same of R, G, B codes, row by row, as they stand.
std::vector<std::byte> encode_png(int width, int height, std::span<const std::uint8_t> rgb);

/// True for channels that say how a picture came about and not what it shows (time, worker):
/// outside the exactness contract.
bool is_diagnostic(std::string_view channel);

/// Nothing if both have the same size and, diagnostic channels aside, the same channels with the
/// same bits. Else one sentence with the first difference and how many values differ. Headers are
/// not compared.
std::optional<std::string> difference(const ExrImage& a, const ExrImage& b);

}  // namespace tessera::image
