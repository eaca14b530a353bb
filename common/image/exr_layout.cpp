#include "common/image/exr_layout.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <type_traits>

namespace tessera::image {

static_assert(std::endian::native == std::endian::little,
              "EXR is little-endian, and values are copied as they are");

namespace {

class Writer {
 public:
  template <class T>
  void value(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto at = bytes_.size();
    bytes_.resize(at + sizeof value);
    std::memcpy(bytes_.data() + at, &value, sizeof value);
  }
  void text(std::string_view text) {
    const auto raw = std::as_bytes(std::span(text.data(), text.size()));
    bytes_.insert(bytes_.end(), raw.begin(), raw.end());
  }
  void terminated(std::string_view name) {
    text(name);
    value(std::uint8_t{0});
  }
  void attribute(std::string_view name, std::string_view type, std::size_t size) {
    terminated(name);
    terminated(type);
    value(static_cast<std::int32_t>(size));
  }
  template <class T>
  void attribute_of(std::string_view name, std::string_view type, const T& content) {
    attribute(name, type, sizeof content);
    value(content);
  }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

void write_channels(Writer& out, const std::vector<std::string_view>& channels) {
  constexpr std::int32_t float_pixels = 2;
  std::size_t size = 1;
  for (const auto name : channels) size += name.size() + 1 + 16;
  out.attribute("channels", "chlist", size);
  for (const auto name : channels) {
    out.terminated(name);
    out.value(std::array<std::int32_t, 4>{float_pixels, 0 /* not perceptually linear */, 1,
                                          1 /* every pixel */});
  }
  out.value(std::uint8_t{0});
}

struct AttributeWriter {
  Writer& out;
  const std::string& name;

  void operator()(const std::string& text) const {
    out.attribute(name, "string", text.size());
    out.text(text);
  }
  void operator()(std::int32_t number) const { out.attribute_of(name, "int", number); }
  void operator()(float number) const { out.attribute_of(name, "float", number); }
  void operator()(double number) const { out.attribute_of(name, "double", number); }
  void operator()(const Matrix& matrix) const { out.attribute_of(name, "m44f", matrix); }
};

}  // namespace

std::vector<std::byte> exr_header(const ExrLayout& layout,
                                  std::span<const Metadata::Attribute> attributes) {
  using Box = std::array<std::int32_t, 4>;
  constexpr std::uint32_t magic = 20000630;
  constexpr std::uint32_t version = 2;
  constexpr std::array<float, 8> rec709{0.64F, 0.33F, 0.30F, 0.60F, 0.15F, 0.06F, 0.3127F, 0.3290F};
  constexpr std::uint8_t uncompressed = 0, zip = 3, increasing_y = 0;
  const Rect& data = layout.data;
  Writer out;
  out.value(magic);
  out.value(version);
  write_channels(out, layout.channels);
  out.attribute_of("compression", "compression",
                   layout.compression == Compression::zip ? zip : uncompressed);
  out.attribute_of("dataWindow", "box2i",
                   Box{data.x, data.y, data.x + data.width - 1, data.y + data.height - 1});
  out.attribute_of("displayWindow", "box2i",
                   Box{0, 0, layout.film_width - 1, layout.film_height - 1});
  out.attribute_of("lineOrder", "lineOrder", increasing_y);
  out.attribute_of("pixelAspectRatio", "float", layout.pixel_aspect);
  out.attribute_of("screenWindowCenter", "v2f", std::array<float, 2>{0, 0});
  out.attribute_of("screenWindowWidth", "float", 1.0F);
  out.attribute_of("chromaticities", "chromaticities", rec709);
  for (const auto& attribute : attributes)
    std::visit(AttributeWriter{out, attribute.name}, attribute.value);
  out.value(std::uint8_t{0});
  return out.take();
}

bool is_layout_attribute(std::string_view name) {
  constexpr std::array<std::string_view, 15> names{"channels",
                                                   "compression",
                                                   "dataWindow",
                                                   "displayWindow",
                                                   "lineOrder",
                                                   "pixelAspectRatio",
                                                   "screenWindowCenter",
                                                   "screenWindowWidth",
                                                   "chromaticities",
                                                   "type",
                                                   "name",
                                                   "version",
                                                   "chunkCount",
                                                   "tiles",
                                                   "preview"};
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::string printable(std::string_view text) {
  std::string out(text.substr(0, 200));
  for (char& c : out)
    if (c < 0x20 || c > 0x7e) c = '?';
  return out;
}

}  // namespace tessera::image
