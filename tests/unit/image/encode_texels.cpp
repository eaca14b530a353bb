#include "tests/unit/image/encode_texels.hpp"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfOutputFile.h>
#include <half.h>
#include <png.h>
#include <webp/encode.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
// jpeglib.h wants stdio before it.
#include <jpeglib.h>

namespace tessera::image {

namespace {

void append(File& file, const void* bytes, std::size_t count) {
  const auto* const from = static_cast<const std::byte*>(bytes);
  file.insert(file.end(), from, from + count);
}

std::vector<std::uint8_t> as_bytes(const Samples& samples) {
  return {samples.begin(), samples.end()};
}

struct PngWriter {
  PngWriter(File& file, int width, int height, int bits, int color_type, bool interlaced) {
    png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    info = png_create_info_struct(png);
    png_set_write_fn(
        png, &file,
        [](png_structp self, png_bytep bytes, png_size_t count) {
          append(*static_cast<File*>(png_get_io_ptr(self)), bytes, count);
        },
        nullptr);
    png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), bits,
                 color_type, interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  }
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;
  ~PngWriter() { png_destroy_write_struct(&png, &info); }
  png_structp png = nullptr;
  png_infop info = nullptr;
};

void write_rows(PngWriter& writer, int bits, const Samples& samples, std::size_t height) {
  png_write_info(writer.png, writer.info);
  png_set_packing(writer.png);
  if (bits == 16) png_set_swap(writer.png);
  const std::size_t row = samples.size() / height;
  std::vector<std::uint8_t> bytes = as_bytes(samples);
  std::vector<png_bytep> rows;
  std::vector<std::uint16_t> wide = samples;
  for (std::size_t y = 0; y < height; ++y)
    rows.push_back(bits == 16 ? reinterpret_cast<png_bytep>(wide.data() + y * row)
                              : bytes.data() + y * row);
  png_write_image(writer.png, rows.data());
  png_write_end(writer.png, nullptr);
}

class MemoryOut : public Imf::OStream {
 public:
  explicit MemoryOut(File& file) : Imf::OStream("memory"), file_(file) {}
  void write(const char* bytes, int count) override {
    const auto size = static_cast<std::size_t>(count);
    if (at_ + size > file_.size()) file_.resize(at_ + size);
    std::memcpy(file_.data() + at_, bytes, size);
    at_ += size;
  }
  std::uint64_t tellp() override { return at_; }
  void seekp(std::uint64_t to) override { at_ = to; }

 private:
  File& file_;
  std::size_t at_ = 0;
};

}  // namespace

File make_png(int width, int height, int bits, int color_type, const Samples& samples,
              bool interlaced) {
  File file;
  PngWriter writer(file, width, height, bits, color_type, interlaced);
  write_rows(writer, bits, samples, static_cast<std::size_t>(height));
  return file;
}

File make_palette_png(int width, int height, const Samples& indices, const Samples& rgb,
                      const Samples& alphas) {
  File file;
  PngWriter writer(file, width, height, 2, PNG_COLOR_TYPE_PALETTE, false);
  std::vector<png_color> palette;
  const std::vector<std::uint8_t> bytes = as_bytes(rgb);
  for (std::size_t i = 0; i + 2 < bytes.size(); i += 3)
    palette.push_back({bytes[i], bytes[i + 1], bytes[i + 2]});
  png_set_PLTE(writer.png, writer.info, palette.data(), static_cast<int>(palette.size()));
  const std::vector<std::uint8_t> clear = as_bytes(alphas);
  if (!clear.empty())
    png_set_tRNS(writer.png, writer.info, clear.data(), static_cast<int>(clear.size()), nullptr);
  write_rows(writer, 2, indices, static_cast<std::size_t>(height));
  return file;
}

File make_jpeg(int width, int height, int channels, const Samples& samples) {
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* out = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&jpeg, &out, &size);
  jpeg.image_width = static_cast<JDIMENSION>(width);
  jpeg.image_height = static_cast<JDIMENSION>(height);
  jpeg.input_components = channels;
  jpeg.in_color_space = channels == 1 ? JCS_GRAYSCALE : channels == 3 ? JCS_RGB : JCS_CMYK;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, 100, TRUE);
  jpeg_start_compress(&jpeg, TRUE);
  std::vector<std::uint8_t> bytes = as_bytes(samples);
  while (jpeg.next_scanline < jpeg.image_height) {
    JSAMPROW row = bytes.data() + static_cast<std::size_t>(jpeg.next_scanline) *
                                      static_cast<std::size_t>(width) *
                                      static_cast<std::size_t>(channels);
    jpeg_write_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_compress(&jpeg);
  jpeg_destroy_compress(&jpeg);
  File file;
  append(file, out, size);
  std::free(out);
  return file;
}

File make_webp(int width, int height, int channels, const Samples& samples) {
  std::uint8_t* out = nullptr;
  const std::vector<std::uint8_t> bytes = as_bytes(samples);
  const std::size_t size =
      channels == 4 ? WebPEncodeLosslessRGBA(bytes.data(), width, height, 4 * width, &out)
                    : WebPEncodeLosslessRGB(bytes.data(), width, height, 3 * width, &out);
  File file;
  append(file, out, size);
  WebPFree(out);
  return file;
}

File make_tga(int width, int height, int channels, const Samples& samples, bool packed) {
  const auto put = [](int value) { return static_cast<std::byte>(value); };
  const int kind = (channels == 1 ? 3 : 2) + (packed ? 8 : 0);
  File file(18, std::byte{0});
  file[2] = put(kind);
  file[12] = put(width & 255);
  file[13] = put(width >> 8);
  file[14] = put(height & 255);
  file[15] = put(height >> 8);
  file[16] = put(8 * channels);
  file[17] = put(channels == 4 ? 8 : 0);
  for (int y = height - 1; y >= 0; --y) {
    for (int x = 0; x < width; ++x) {
      if (packed) file.push_back(put(x % 2 == 0 ? 128 : 0));  // a run of one, or one as it stands
      const std::size_t at =
          static_cast<std::size_t>(y * width + x) * static_cast<std::size_t>(channels);
      static constexpr int order[4][4] = {{0}, {}, {2, 1, 0}, {2, 1, 0, 3}};
      for (int c = 0; c < channels; ++c)
        file.push_back(put(samples[at + static_cast<std::size_t>(order[channels - 1][c])]));
    }
  }
  return file;
}

File make_hdr(int width, int height, const std::vector<std::uint8_t>& rgbe, bool packed) {
  const std::string header = "#?RADIANCE\n# made by a test\nFORMAT=32-bit_rle_rgbe\n\n-Y " +
                             std::to_string(height) + " +X " + std::to_string(width) + "\n";
  File file;
  append(file, header.data(), header.size());
  if (!packed) {
    append(file, rgbe.data(), rgbe.size());
    return file;
  }
  const auto put = [&](int value) { file.push_back(static_cast<std::byte>(value)); };
  for (int y = 0; y < height; ++y) {
    for (const int value : {2, 2, width >> 8, width & 255}) put(value);
    for (int c = 0; c < 4; ++c) {
      const auto at = [&](int x) {
        return rgbe[static_cast<std::size_t>((y * width + x) * 4 + c)];
      };
      for (int x = 0; x < width;) {
        int run = 1;
        while (x + run < width && run < 127 && at(x + run) == at(x)) ++run;
        put(run > 1 ? 128 + run : 1);
        put(at(x));
        x += run;
      }
    }
  }
  return file;
}

File make_exr(int width, int height, std::string_view channels, bool halves,
              const std::vector<float>& planes) {
  File file;
  Imf::Header header(width, height);
  for (const char c : channels)
    header.channels().insert(std::string(1, c), Imf::Channel(halves ? Imf::HALF : Imf::FLOAT));
  const std::vector<half> small(planes.begin(), planes.end());
  Imf::FrameBuffer buffer;
  const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  const std::size_t size = halves ? 2 : 4;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const void* const plane = halves ? static_cast<const void*>(small.data() + i * pixels)
                                     : static_cast<const void*>(planes.data() + i * pixels);
    buffer.insert(std::string(1, channels[i]),
                  Imf::Slice::Make(halves ? Imf::HALF : Imf::FLOAT, plane, header.dataWindow(),
                                   size, size * static_cast<std::size_t>(width)));
  }
  MemoryOut out(file);
  Imf::OutputFile writer(out, header);
  writer.setFrameBuffer(buffer);
  writer.writePixels(height);
  return file;
}

}  // namespace tessera::image
