#include <fmt/format.h>

#include <array>
#include <csetjmp>
#include <cstdio>
// jpeglib.h wants stdio before it.
#include <jerror.h>
#include <jpeglib.h>

#include "common/image/texels_decode.hpp"

namespace tessera::image {

namespace {

/// A file that is decoded scan after scan would take its size times this.
constexpr int scans_most = 500;

/// Each block of 64 coefficients takes a bit at least: its first coefficient has a Huffman code.
std::uint64_t least_bytes(const jpeg_decompress_struct& jpeg) {
  std::uint64_t blocks = 0;
  for (int i = 0; i < jpeg.num_components; ++i)
    blocks += std::uint64_t{jpeg.comp_info[i].width_in_blocks} * jpeg.comp_info[i].height_in_blocks;
  return blocks / 8;
}

/// libjpeg leaves by longjmp, so what calls it holds nothing that has a destructor.
struct Reader {
  Reader() {
    jpeg.err = jpeg_std_error(&errors);
    errors.error_exit = on_error;
    errors.emit_message = on_message;
    jpeg.client_data = this;
    progress.progress_monitor = on_progress;
  }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
  ~Reader() { jpeg_destroy_decompress(&jpeg); }

  static Reader& of(j_common_ptr jpeg) { return *static_cast<Reader*>(jpeg->client_data); }
  static void on_error(j_common_ptr jpeg) {
    Reader& self = of(jpeg);
    jpeg->err->format_message(jpeg, self.said.data());
    std::longjmp(self.back, 1);
  }
  /// libjpeg makes up what a short file lacks, and says so in a warning alone.
  static void on_message(j_common_ptr jpeg, int level) {
    const int code = jpeg->err->msg_code;
    if (level < 0 && (code == JWRN_JPEG_EOF || code == JWRN_HIT_MARKER)) on_error(jpeg);
  }
  static void on_progress(j_common_ptr jpeg) {
    if (reinterpret_cast<j_decompress_ptr>(jpeg)->input_scan_number <= scans_most) return;
    std::snprintf(of(jpeg).said.data(), of(jpeg).said.size(), "more than %d scans", scans_most);
    std::longjmp(of(jpeg).back, 1);
  }

  jpeg_decompress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg_progress_mgr progress{};
  std::jmp_buf back{};
  std::array<char, JMSG_LENGTH_MAX> said{};
};

bool read_header(Reader& reader, const std::byte* file, std::size_t size) {
  if (setjmp(reader.back) != 0) return false;
  jpeg_create_decompress(&reader.jpeg);
  reader.jpeg.progress = &reader.progress;
  jpeg_mem_src(&reader.jpeg, reinterpret_cast<const unsigned char*>(file), size);
  jpeg_read_header(&reader.jpeg, TRUE);
  return true;
}

bool read_rows(Reader& reader, std::byte* to, std::size_t row_bytes) {
  if (setjmp(reader.back) != 0) return false;
  jpeg_start_decompress(&reader.jpeg);
  while (reader.jpeg.output_scanline < reader.jpeg.output_height) {
    auto* row = reinterpret_cast<JSAMPROW>(to + reader.jpeg.output_scanline * row_bytes);
    jpeg_read_scanlines(&reader.jpeg, &row, 1);
  }
  jpeg_finish_decompress(&reader.jpeg);
  return true;
}

}  // namespace

Texels decode_jpeg(std::span<const std::byte> file, const PictureSource& source) {
  const std::string& name = source.name;
  Reader reader;
  const auto refuse = [&] {
    refuse_picture(name, fmt::format("not a valid JPEG file: {}", reader.said.data()));
  };
  if (!read_header(reader, file.data(), file.size())) refuse();
  const J_COLOR_SPACE space = reader.jpeg.jpeg_color_space;
  if (space == JCS_CMYK || space == JCS_YCCK)
    refuse_picture(name, "a JPEG for print (CMYK); expected gray or colour for screens");
  if (reader.jpeg.arith_code != FALSE)
    refuse_picture(name, "a JPEG with arithmetic coding; expected one with Huffman codes");
  const bool gray = space == JCS_GRAYSCALE;
  reader.jpeg.out_color_space = gray ? JCS_GRAYSCALE : JCS_RGB;
  Texels out = picture_of(reader.jpeg.image_width, reader.jpeg.image_height, gray ? 1 : 3,
                          TexelFormat::u8, source, least_bytes(reader.jpeg), file.size());
  if (!read_rows(reader, out.bytes.data(), out.row_bytes())) refuse();
  return out;
}

}  // namespace tessera::image
