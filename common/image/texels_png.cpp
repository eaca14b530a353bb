#include <fmt/format.h>
#include <png.h>

#include <array>
#include <csetjmp>
#include <cstring>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "common/image/texels_decode.hpp"

namespace tessera::image {

namespace {

/// Bytes that one byte of a deflated stream can stand for, at most.
constexpr std::uint64_t densest_deflate = 1032;

/// libpng's two structures. It leaves by longjmp, so what calls it holds nothing that has a
/// destructor.
struct Reader {
  explicit Reader(std::span<const std::byte> file) : rest(file) {
    png = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, on_error, on_warning);
    if (png != nullptr) info = png_create_info_struct(png);
  }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
  ~Reader() { png_destroy_read_struct(&png, &info, nullptr); }

  static void on_error(png_structp png, png_const_charp message) {
    auto& self = *static_cast<Reader*>(png_get_error_ptr(png));
    std::strncpy(self.said.data(), message, self.said.size() - 1);
    std::longjmp(self.back, 1);
  }
  static void on_warning(png_structp /*png*/, png_const_charp /*message*/) {}
  static void read(png_structp png, png_bytep to, png_size_t count) {
    auto& self = *static_cast<Reader*>(png_get_io_ptr(png));
    if (count > self.rest.size()) png_error(png, "the file ends too early");
    std::memcpy(to, self.rest.data(), count);
    self.rest = self.rest.subspan(count);
  }

  std::span<const std::byte> rest;
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::jmp_buf back{};
  std::array<char, 160> said{};
};

/// Rows will come as gray, gray and alpha, RGB or RGBA of 8 or 16 bits.
bool read_header(Reader& reader) {
  if (setjmp(reader.back) != 0) return false;
  png_set_read_fn(reader.png, &reader, Reader::read);
  png_set_user_limits(reader.png, limits::image_side, limits::image_side);
  png_set_chunk_malloc_max(reader.png, 8 * limits::MiB);
  png_set_chunk_cache_max(reader.png, 64);
  png_read_info(reader.png, reader.info);
  png_set_expand(reader.png);
  png_set_swap(reader.png);
  return true;
}

bool read_rows(Reader& reader, std::byte* to, std::size_t row_bytes, int height) {
  if (setjmp(reader.back) != 0) return false;
  const int passes = png_set_interlace_handling(reader.png);
  png_read_update_info(reader.png, reader.info);
  if (png_get_rowbytes(reader.png, reader.info) != row_bytes) png_error(reader.png, "odd rows");
  for (int pass = 0; pass < passes; ++pass)
    for (int y = 0; y < height; ++y)
      png_read_row(reader.png,
                   reinterpret_cast<png_bytep>(to + static_cast<std::size_t>(y) * row_bytes),
                   nullptr);
  png_read_end(reader.png, nullptr);
  return true;
}

}  // namespace

Texels decode_png(std::span<const std::byte> file, const PictureSource& source) {
  const std::string& name = source.name;
  Reader reader(file);
  if (reader.info == nullptr) throw Error(ErrorKind::failed, "libpng could not be started");
  const auto refuse = [&] {
    refuse_picture(name, fmt::format("not a valid PNG file: {}", reader.said.data()));
  };
  if (!read_header(reader)) refuse();
  const int color = png_get_color_type(reader.png, reader.info);
  const bool clear_color = png_get_valid(reader.png, reader.info, PNG_INFO_tRNS) != 0;
  const bool alpha = (color & PNG_COLOR_MASK_ALPHA) != 0 || clear_color;
  const int channels = ((color & PNG_COLOR_MASK_COLOR) != 0 ? 3 : 1) + (alpha ? 1 : 0);
  const bool deep = png_get_bit_depth(reader.png, reader.info) == 16;
  const std::uint64_t height = png_get_image_height(reader.png, reader.info);
  const std::uint64_t packed_bytes = height * png_get_rowbytes(reader.png, reader.info);
  Texels out =
      picture_of(png_get_image_width(reader.png, reader.info), static_cast<std::int64_t>(height),
                 channels, deep ? TexelFormat::u16 : TexelFormat::u8, source,
                 packed_bytes / densest_deflate, file.size());
  if (!read_rows(reader, out.bytes.data(), out.row_bytes(), out.height)) refuse();
  return out;
}

}  // namespace tessera::image
